// A Fortran program reads viewpeel's Elmer files as Elmer does, and SYRTHES itself reads its file. MOOSE's text is
// compared as text.
#include <array>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/write.h>
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class SmallFormats : public TestFolder {
 protected:
  static Ids unequalRows(uint32_t count) {
    Ids ids;
    for (uint32_t k = 0; k < count; ++k) {
      ids.names.push_back(fmt::format("wall{}", k));
      ids.areas.push_back(1 + 0.37 * k);
      ids.surface.push_back(k);
    }
    return ids;
  }
  static std::vector<std::vector<double>> dense(const FormFactors& f) {
    std::vector<std::vector<double>> values(f.ids().count(), std::vector<double>(f.ids().count()));
    for (uint32_t i = 0; i < f.ids().count(); ++i)
      for (uint32_t j = 0; j < f.ids().count(); ++j) values[i][j] = f.formFactor(i, j).value;
    return values;
  }
  void expectPassed(const std::string& script) const {
    const PythonResult result = runPython(folder_, script + "print('passed')\n");
    EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
  }
};

// Elmer reads text by list-directed READ, and bytes by access='stream'. This program does the same and prints the
// matrix.
constexpr const char* kReader = R"(program reader
  implicit none
  integer, parameter :: n = 7
  real(8) :: f(n, n), value
  integer :: i, j, k, m, row, rows
  character(32) :: kind
  f = 0
  call get_command_argument(1, kind)
  if (kind == 'text') then
    open(10, file='ViewFactors.dat', status='old')
    do i = 1, n
      read(10, *) m
      do k = 1, m
        read(10, *) row, j, value
        if (row /= i) stop 1
        f(i, j) = value
      end do
    end do
  else
    open(10, file='ViewFactors.bin.dat', status='old', form='unformatted', access='stream')
    read(10) rows
    if (rows /= n) stop 2
    do i = 1, n
      read(10) m
      do k = 1, m
        read(10) j, value
        f(i, j) = value
      end do
    end do
  end if
  do i = 1, n
    write(*, '(7es25.16e3)') f(i, :)
  end do
end program reader
)";

TEST_F(SmallFormats, FortranReadsElmersFiles) {
  const FormFactors f = randomFormFactors(unequalRows(7), 21, 0.7);
  writeFormFactors(f, folder_ / "ViewFactors.dat");
  writeFormFactors(f, folder_ / "ViewFactors.bin.dat");
  std::ofstream(folder_ / "reader.f90") << kReader;
  ASSERT_EQ(std::system(fmt::format("cd '{}' && gfortran -o reader reader.f90 >said 2>&1 && ./reader text >text.txt && "
                                    "./reader binary >binary.txt",
                                    folder_.string())
                            .c_str()),
            0);
  expectPassed(fmt::format("import numpy as np\nF = np.array({})\n", dense(f)) +
               "for name in ('text.txt', 'binary.txt'):\n"
               "    found = np.loadtxt(name)\n"
               "    assert (found == F).all()\n"
               "    order = [1, 0, 2, 3, 4, 5, 6]\n"
               "    assert (found != F[order]).any() and (found != F.T).any()\n");
}

TEST_F(SmallFormats, MooseHasRowsInTheOrderOfItsBoundaries) {
  const FormFactors f = randomFormFactors(unequalRows(5), 22);
  writeFormFactors(f, folder_ / "vf.i");
  expectPassed(fmt::format("import re, numpy as np\nF = np.array({})\n", dense(f)) +
               "text = open('vf.i').read()\n"
               "value = dict(re.findall(r\"(\\w+) = ('[^']*'|\\S+)\", text))\n"
               "assert value['type'] == 'SpecifiedViewFactor' and value['normalize_view_factor'] == 'false'\n"
               "assert value['boundary'] == \"'wall0 wall1 wall2 wall3 wall4'\"\n"
               "found = np.array([[float(x) for x in row.split()] for row in "
               "value['view_factors'].strip(\"'\").split(';')])\n"
               "assert (found == F).all()\n"
               "order = [1, 0, 2, 3, 4]\n"
               "assert (found != F[order]).any() and (found != F.T).any()\n"
               "assert text.count('[') == text.count(']') == 4\n");
  Scene scene;
  Ids ids = f.ids();
  EXPECT_NO_THROW(checkRows(folder_ / "vf.i", scene, ids));
  ids.names[2] = "north wall";
  EXPECT_THROW(checkRows(folder_ / "vf.i", scene, ids), Error);
}

// This is SYRTHES's example of two plates, with the file of form factors that SYRTHES computed.
constexpr const char* kCase = "/usr/share/syrthes/tests/cas_plates3d_salome";

FormFactors readFdf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const auto get = [&]<class T>(std::vector<T>& values) {
    in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  };
  std::vector<int32_t> n(1);
  get(n);
  std::vector<double> diagonal(static_cast<size_t>(n[0]));
  std::vector<int32_t> counts(diagonal.size());
  get(diagonal);
  get(counts);
  Ids ids;
  std::vector<FormFactors::Entry> entries;
  for (uint32_t i = 0; i < diagonal.size(); ++i) {
    std::vector<int32_t> columns(static_cast<size_t>(counts[i]));
    std::vector<double> values(columns.size());
    get(columns);
    get(values);
    double area = diagonal[i];
    entries.push_back({i, i, {diagonal[i], 0}});
    for (size_t k = 0; k < columns.size(); ++k) {
      area += values[k];
      if (static_cast<uint32_t>(columns[k]) > i)
        entries.push_back({i, static_cast<uint32_t>(columns[k]), {values[k], 0}});
    }
    ids.names.push_back(fmt::format("facet{}", i));
    ids.areas.push_back(area);
    ids.surface.push_back(i);
  }
  std::vector<Measured> sums(ids.count(), Measured{1, 0});
  return {ids, std::move(entries), std::move(sums)};
}

// SYRTHES's form factors, read and written again, give the same solution. Negative control: with the two halves of the
// rows swapped they do not.
TEST_F(SmallFormats, SyrthesSolvesWithItsOwnFactorsWrittenHere) {
  const FormFactors own = readFdf(fs::path(kCase) / "syrthes/mesh.fdf");
  ASSERT_EQ(own.ids().count(), 2617u);
  writeFormFactors(own, folder_ / "again.fdf");
  expectPassed(fmt::format("case = '{}'\n", kCase) + R"(
import os, shutil, subprocess, numpy as np
def read(name):
    with open(name, 'rb') as f:
        n = np.fromfile(f, '<i4', 1)[0]
        d, c = np.fromfile(f, '<f8', n), np.fromfile(f, '<i4', n)
        rows = [(np.fromfile(f, '<i4', k), np.fromfile(f, '<f8', k)) for k in c]
        assert not f.read(1)
    return d, rows
a, b = read(case + '/syrthes/mesh.fdf'), read('again.fdf')
assert all((x[0] == y[0]).all() for x, y in zip(a[1], b[1])) and len(a[1]) == len(b[1])
# SYRTHES has two numbers for a pair, which differ in the last digits of its single precision; here it is one.
def dense(rows):
    m = np.zeros((len(rows), len(rows)))
    for i, (columns, values) in enumerate(rows):
        m[i, columns] = values
    return m
A, B = dense(a[1]), dense(b[1])
assert (abs(A - B) <= abs(A - A.T) + 1e-18).all() and (abs(B - B.T) <= 1e-15 * B).all()
assert (abs(a[0] - b[0]) <= abs(A - A.T).sum(axis=1) + 1e-15).all()
subprocess.run(['gcc', '-o', 'syrthes', '/usr/lib/syrthes/lib/libsyrthes_seq.a', '-lm'], check=True)
text = open(case + '/syrthes/plates3d.syd').read()
for old, new in (('../salome/', case + '/salome/'), ('PAS DE TEMPS SOLIDES= 230', 'PAS DE TEMPS SOLIDES= 3'),
                 ('FORME SUR FICHIER= NON', 'FORME SUR FICHIER= OUI')):
    assert old in text
    text = text.replace(old, new)
open('case.syd', 'w').write(text)
def solve():
    r = subprocess.run(['./syrthes', '-d', 'case.syd'], capture_output=True, text=True)
    assert r.returncode == 0 and 'FIN NORMALE' in r.stdout, r.stdout[-2000:]
    return np.loadtxt('resu1.his')[:, 1]
shutil.copy(case + '/syrthes/mesh.fdf', 'mesh.fdf')
truth = solve()
shutil.copy('again.fdf', 'mesh.fdf')
same = solve()
n = len(b[0])
to = (np.arange(n) + n // 2) % n
order = np.argsort(to)
with open('mesh.fdf', 'wb') as f:
    f.write(np.int32(n).tobytes() + b[0][order].tobytes())
    f.write(np.array([len(b[1][i][0]) for i in order], '<i4').tobytes())
    for i in order:
        columns = to[b[1][i][0]]
        s = np.argsort(columns)
        f.write(columns[s].astype('<i4').tobytes() + b[1][i][1][s].tobytes())
other = solve()
found = abs(same - truth).max(), abs(other - truth).max()
print(found)
assert found[0] < 0.01 < 1 < found[1], found
)");
}

// The diagonal F_ii takes what a row lacks, except for the radiation that leaves an open scene. So the area times the
// row sum in the file is A_i (1 - F_i,environment). A file keeps doubles: only sums of a few terms round.
TEST_F(SmallFormats, SyrthesDiagonalIsWithoutTheEnvironment) {
  const FormFactors f = randomFormFactors(unequalRows(4), 23);
  writeFormFactors(f, folder_ / "mesh.fdf");
  const FormFactors read = readFdf(folder_ / "mesh.fdf");
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(read.ids().areas[i], f.ids().areas[i] * (1 - f.formFactor(i, kEnvironment).value), 1e-14);
    for (uint32_t j = i + 1; j < 4; ++j) EXPECT_NEAR(read.exchangeArea(i, j).value, f.exchangeArea(i, j).value, 1e-15);
  }
}

}  // namespace
}  // namespace viewpeel
