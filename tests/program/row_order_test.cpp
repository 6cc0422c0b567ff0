// Rows and columns stand in the order of the faces in the file in every format, whatever counts them. Guessed form
// factors are marked in every format that has a column for it.
#include <fmt/format.h>

#include "tests/support/program.h"
#include "tests/support/python.h"

namespace viewpeel {
namespace {

class RowOrder : public Program {
 protected:
  void judge(const std::string& script) const {
    const PythonResult judged = runPython(folder_, script);
    EXPECT_EQ(judged.status, 0) << judged.output;
  }
  std::string outputs() const {
    std::string text = " --quiet";
    for (const char* end : {"csv", "rows.csv", "mtx", "npz", "h5", "json", "vtp", "vwf", "dat"})
      text += fmt::format(" -o {}", file(std::string("o.") + end));
    return text;
  }
};

// The scene is a part of a pyramid around a tetrahedron. No two of the ten faces have the same area, surfaces take
// turns in the file, and the tetrahedron blocks some pairs in part.
constexpr const char* kMakeScene = R"(
import numpy as np
low = np.array([(0, 0, 0), (3, 0, 0), (3, 2, 0), (0, 2, 0)], float)
corners = np.vstack([low, (low + (1, 0.7, 2)) / 2,
                     [(0.8, 0.5, 0.1), (1.7, 0.6, 0.2), (1.2, 1.3, 0.3), (1.4, 0.7, 0.8)]])
faces = [('b', (0, 3, 7, 4)), ('a', (0, 1, 2, 3)), ('d', (8, 10, 9)), ('b', (1, 5, 6, 2)), ('c', (7, 6, 5, 4)),
         ('d', (8, 9, 11)), ('a', (0, 4, 5, 1)), ('d', (9, 10, 11)), ('b', (3, 2, 6, 7)), ('d', (10, 8, 11))]
def area(face):
    p = corners[list(face)]
    return np.linalg.norm(sum(np.cross(p[k] - p[0], p[k + 1] - p[0]) for k in range(1, len(p) - 1))) / 2
areas = np.array([area(face) for _, face in faces])
assert np.diff(np.sort(areas)).min() > 0.01, areas
count, names = {}, []
for name, _ in faces:
    count[name] = count.get(name, 0) + 1
    names.append(f'{name}[{count[name]}]' if name != 'c' else 'c')
)";

constexpr const char* kWriteScene = R"(
with open('scene.obj', 'w') as out:
    for p in corners: print('v', *p, file=out)
    for name, face in faces: print(f'o {name}\nf', *(k + 1 for k in face), file=out)
)";

// A matrix in another order breaks A_i F_ij = A_j F_ji, for all areas differ. The negative control swaps two rows and
// columns. Form factors are written to 17 digits, and areas and quotients are rounded by less than 1e-14 of them.
constexpr const char* kReadAll = R"(
import csv, json, h5py, scipy.io, scipy.sparse, vtkmodules.vtkIOXML as xml
from vtkmodules.util.numpy_support import vtk_to_numpy
if by_surface:
    order = list(dict.fromkeys(name for name, _ in faces))
    areas = np.array([sum(a for a, (name, _) in zip(areas, faces) if name == of) for of in order])
    names = order
n = len(names)
rows = list(csv.DictReader(open('o.rows.csv')))
assert [r['name'] for r in rows] == names and [int(r['row']) for r in rows] == list(range(1, n + 1))
assert np.allclose([float(r['area']) for r in rows], areas, rtol=1e-14)
found = {'csv': np.zeros((n, n)), 'dat': np.zeros((n, n)), 'json': np.zeros((n, n)), 'vwf': np.zeros((n, n))}
last = -1
for r in csv.DictReader(open('o.csv')):
    assert names.index(r['from']) >= last
    last = names.index(r['from'])
    if r['to'] in names: found['csv'][last, names.index(r['to'])] = float(r['form_factor'])
found['mtx'] = scipy.io.mmread('o.mtx').toarray()
found['npz'] = scipy.sparse.load_npz('o.npz').toarray()
h5, js = h5py.File('o.h5'), json.load(open('o.json'))
g = h5['form_factors']
found['h5'] = scipy.sparse.csr_matrix((g['data'][:], g['indices'][:], g['indptr'][:]), g.attrs['shape']).toarray()
assert list(h5['name'].asstr()) == names == [r['name'] for r in js['rows']]
for e in js['form_factors']['entries']: found['json'][e[0], e[1]] = e[2]
for line in open('o.dat'):
    if len(line.split()) == 3:
        i, j, f = line.split()
        found['dat'][int(i) - 1, int(j) - 1] = float(f)
data, at, records = open('o.vwf', 'rb').read(), 0, []
while at < len(data):
    size = int.from_bytes(data[at:at + 4], 'little')
    records.append(data[at + 4:at + 4 + size])
    at += size + 8
pairs = np.frombuffer(max(records[1:], key=len))  # below the diagonal, column by column: F(row, column) of all pairs
below = [(r, c) for c in range(n) for r in range(c + 1, n)]
for k, (r, c) in enumerate(below):
    found['vwf'][r, c], found['vwf'][c, r] = pairs[k], pairs[len(below) + k]
np.fill_diagonal(found['vwf'], np.diag(found['csv']))  # CalculiX has it in a record of its own
def mismatch(F): return abs(areas[:, None] * F - (areas[:, None] * F).T).max()
swapped = list(range(n))
swapped[0], swapped[1] = 1, 0
for name, F in found.items():
    assert (F == found['csv']).all(), name
    assert mismatch(F) < 1e-14 * areas.max() < 1e-3 < mismatch(F[swapped][:, swapped]), name
reader = xml.vtkXMLPolyDataReader()
reader.SetFileName('o.vtp')
reader.Update()
cells = reader.GetOutput().GetCellData()
row, sums = vtk_to_numpy(cells.GetArray('row')), vtk_to_numpy(cells.GetArray('row_sum'))
assert set(row) == set(range(n))
for k, r in zip(row, sums): assert r == float(rows[k]['row_sum'])
)";

TEST_F(RowOrder, IsThatOfTheFileInEveryFormat) {
  judge(std::string(kMakeScene) + kWriteScene);
  for (const char* options :
       {"--tolerance 0.02 --promise on", "--tolerance 0.02 --promise off", "--directions 40 --unoccluded on",
        "--directions 40 --unoccluded off", "--directions 4 --engine exact --unoccluded off"})
    for (const char* by : {"polygon", "surface"}) {
      SCOPED_TRACE(fmt::format("{} --by {}", options, by));
      ASSERT_EQ(run(fmt::format("compute {} {} --by {} {}", file("scene.obj"), options, by, outputs())).status, 0);
      judge(fmt::format("by_surface = {}\n", std::string(by) == "surface" ? "True" : "False") + kMakeScene + kReadAll);
    }
}

// Every guess is a pair that no line met. A run without unoccluded form factors has the same lines, and no entry for
// such a pair. The other form factors there have entries, but for pairs that all lines found blocked.
TEST_F(RowOrder, GuessesAreMarkedAlikeInEveryFormat) {
  const std::string office = "compute " VIEWPEEL_SCENES
                             "/office.obj --directions 20 --resolution 32 --replicates 4 --sampling lattice --quiet ";
  ASSERT_EQ(
      run(fmt::format("{} --unoccluded on -o {} -o {} -o {}", office, file("o.csv"), file("o.h5"), file("o.json")))
          .status,
      0);
  ASSERT_EQ(run(fmt::format("{} --unoccluded off -o {}", office, file("met.csv"))).status, 0);
  judge(R"(
import csv, h5py, json
table = list(csv.DictReader(open('o.csv')))
marks = {(r['from'], r['to']): int(r['is_guess']) for r in table if r['to'] not in ('environment', 'leak')}
met = {(r['from'], r['to']) for r in csv.DictReader(open('met.csv'))} & marks.keys()
assert sum(marks.values()) > 1000 and len(met) > 10000
assert not any(marks[key] for key in met)
rest = [mark for key, mark in marks.items() if key not in met]
assert sum(rest) > len(rest) / 2, (sum(rest), len(rest))
assert all(marks[j, i] == mark for (i, j), mark in marks.items())
h5, js = h5py.File('o.h5'), json.load(open('o.json'))
names = list(h5['name'].asstr())
assert {(names[i], names[j]): m for i, j, m in zip(h5['from'][:], h5['to'][:], h5['is_guess'][:])} == marks
mark = js['form_factors']['columns'].index('is_guess')
assert {(names[e[0]], names[e[1]]): int(e[mark]) for e in js['form_factors']['entries']} == marks
)");
}

}  // namespace
}  // namespace viewpeel
