// uDALES runs View3D for form factors and reads its file; in these tests it runs view3d in View3D's place.
#include <gtest/gtest.h>

#include "tests/support/python.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

class Udales : public TestFolder {};

// uDALES (tools/python/udgeom/view3d.py) writes .vs3 with CRLF and one facet a triangle, and runs the executable that
// VIEW3D_EXE names. It reads the sparse layout, and takes the lacks of rows as the sky's view factors. Two boxes stand
// on the ground.
TEST_F(Udales, TakesTheProgramForView3d) {
  std::filesystem::copy_file(VIEWPEEL_PROGRAM, folder_ / "view3d");
  const PythonResult result = runPython(folder_, R"(
import itertools, os, subprocess, numpy as np
from scipy import sparse
facets = []
def quad(a, b, c, d):
    facets.extend([(a, b, c), (a, c, d)])
step = [(-4 + 2 * i, -4 + 2 * j) for i in range(4) for j in range(4)]  # of the ground, 8 m wide
boxes = [(-2, 0, 1.5), (0, -2, 3)]  # corner and height; 2 m wide
for x, y in step:
    if (x, y) not in [(b[0], b[1]) for b in boxes]:
        quad((x, y, 0), (x + 2, y, 0), (x + 2, y + 2, 0), (x, y + 2, 0))
for x, y, h in boxes:
    x1, y1 = x + 2, y + 2
    quad((x, y, 0), (x1, y, 0), (x1, y, h), (x, y, h))
    quad((x1, y, 0), (x1, y1, 0), (x1, y1, h), (x1, y, h))
    quad((x1, y1, 0), (x, y1, 0), (x, y1, h), (x1, y1, h))
    quad((x, y1, 0), (x, y, 0), (x, y, h), (x, y1, h))
    quad((x, y, h), (x1, y, h), (x1, y1, h), (x, y1, h))
n = len(facets)
with open('facets.vs3', 'w', newline='\r\n') as file:
    file.write('T\nC out=2 maxD=1000 row=0 col=0\nF 3\n')
    for k, point in enumerate(itertools.chain(*facets)):
        file.write('V %4d %6.6f %6.6f %6.6f\n' % (k + 1, *point))
    for k in range(n):
        file.write('S %4d %4d %4d %4d 0 0 0 0 %6df\n' % (k + 1, 3 * k + 1, 3 * k + 2, 3 * k + 3, k + 1))
    file.write('End of Data\n')
exe = os.path.abspath('view3d')
subprocess.run([exe, 'facets.vs3', 'vf.txt'], check=True, stderr=subprocess.DEVNULL)
ijF = np.loadtxt('vf.txt')
vf = sparse.csr_matrix((ijF[:, 2], (ijF[:, 0].astype(int) - 1, ijF[:, 1].astype(int) - 1)), shape=(n, n))
areas = np.array([np.linalg.norm(np.cross(np.subtract(b, a), np.subtract(c, a))) / 2 for a, b, c in facets])
rows = np.asarray(vf.sum(axis=1)).ravel()
svf = np.maximum(1 - rows, 0)
assert abs(rows + svf - 1).max() <= 1e-3 and rows.max() < 2, rows.max()
exchange = sparse.diags(areas) @ vf
assert abs(exchange - exchange.T).sum() <= 0.01 * exchange.sum()
# Roofs: nothing is above the higher one; the lower one sees the other box.
assert svf[-2:].min() > 1 - 1e-6 and rows[-2:].max() < 1e-6
assert 0.05 < rows[n - 12:n - 10].max() < 0.5, rows
# Rows swapped are found out: areas differ.
order = np.arange(n)
order[[0, n - 1]] = order[[n - 1, 0]]
wrong = sparse.diags(areas) @ vf[order]
assert abs(wrong - wrong.T).sum() > 0.01 * exchange.sum()
print('passed')
)");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace viewpeel
