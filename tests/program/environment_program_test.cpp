// `compute --only environment` and `--up` write the environment, and its parts sky and ground, in every format.
#include <fmt/format.h>

#include "tests/support/program.h"
#include "tests/support/python.h"

namespace viewpeel {
namespace {

const std::string kStreet = VIEWPEEL_SCENES "/street.obj ";

class EnvironmentProgram : public Program {
 protected:
  // Runs a Python script, which reads the files and asserts what they have to contain.
  void judge(const std::string& script) const {
    const PythonResult judged = runPython(folder_, R"(
import csv, h5py, json, vtkmodules.vtkIOXML as xml
from vtkmodules.util.numpy_support import vtk_to_numpy
columns = ['environment', 'environment_up', 'environment_down']
rows = list(csv.DictReader(open('a.rows.csv')))
entries = {}
for r in csv.DictReader(open('a.csv')):
    entries[r['from'], r['to']] = float(r['form_factor']), float(r['standard_error'])
h5, js = h5py.File('a.h5'), json.load(open('a.json'))
reader = xml.vtkXMLPolyDataReader()
reader.SetFileName('a.vtp')
reader.Update()
cells = reader.GetOutput().GetCellData()
row_of_cell = vtk_to_numpy(cells.GetArray('row'))
for k, r in enumerate(rows):
    for column, to in zip(columns, ('environment', 'environment:up', 'environment:down')):
        value, error = float(r[column]), float(r[column + '_standard_error'])
        assert entries.get((r['name'], to), (0, 0)) == (value, error), (r['name'], to)
        assert h5[column][k] == value and h5[column + '_standard_error'][k] == error
        assert js['rows'][k][column] == value and js['rows'][k][column + '_standard_error'] == error
        assert vtk_to_numpy(cells.GetArray(column))[list(row_of_cell).index(k)] == value
    both = float(r['environment_up']) + float(r['environment_down'])
    assert abs(both - float(r['environment'])) < 1e-14
)" + script);
    EXPECT_EQ(judged.status, 0) << judged.output;
  }
  std::string outputs() const {
    std::string text = " --quiet";
    for (const char* name : {"a.csv", "a.rows.csv", "a.h5", "a.json", "a.vtp"}) text += " -o " + file(name);
    return text;
  }
};

// Small triangles need so many rays at this goal that the lines of all pairs are less work. They give the same form
// factors as a run of all form factors does; rays then divide them.
TEST_F(EnvironmentProgram, SmallTrianglesHaveThatOfTheirPairs) {
  std::ofstream scene(file("small.obj"));
  scene << "o floor\nv -3 -3 0\nv 3 -3 0\nv 3 3 0\nv -3 3 0\nf 1 2 3 4\n";
  for (int k = 0; k < 300; ++k)
    scene << fmt::format("o small{0}\nv {1} 0 0.2\nv {1} 0.02 0.2\nv {1} 0 0.22\nf -3 -2 -1\n", k, -2.25 + 0.015 * k);
  scene.close();
  const std::string words = "compute " + file("small.obj") + " --by polygon --tolerance 1e-3 ";
  const Result alone = run(words + "--only environment --up 0,0,1 -o " + file("a.rows.csv"));
  ASSERT_EQ(alone.status, 0) << alone.output;
  EXPECT_NE(shownValue(alone.output, "work").find("; lines of "), std::string::npos) << alone.output;
  EXPECT_NE(shownValue(alone.output, "work").find(" rows of their own"), std::string::npos) << alone.output;
  ASSERT_EQ(run(words + "--promise off -q -o " + file("all.rows.csv")).status, 0);
  const PythonResult judged = runPython(folder_, R"(
import csv
a, b = (list(csv.DictReader(open(name))) for name in ('a.rows.csv', 'all.rows.csv'))
assert len(a) == len(b) == 301
for x, y in zip(a, b):
    assert x['name'] == y['name'] and x['environment'] == y['environment'], (x, y)
    up, down, whole = (float(x['environment' + part]) for part in ('_up', '_down', ''))
    assert abs(up + down - whole) < 1e-14, x
    assert float(x['environment_up_standard_error']) <= 1.5e-3, x
small = [float(x['environment_up']) for x in a[1:]]
assert 0.2 < min(small) and max(small) < 0.6, small  # upright triangles: half the sky, less what others hide
)");
  EXPECT_EQ(judged.status, 0) << judged.output;
}

TEST_F(EnvironmentProgram, AloneIsThatOfAllFormFactors) {
  ASSERT_EQ(run("compute " + kStreet + "--only environment --up 0,0,1 --tolerance 3e-3" + outputs()).output, "");
  ASSERT_EQ(run("compute " + kStreet + "--tolerance 3e-3 --promise off --seed 7 --quiet -o " + file("all.csv")).output,
            "");
  judge(R"(
whole = {r['from']: (float(r['form_factor']), float(r['standard_error'])) for r in csv.DictReader(open('all.csv'))
       if r['to'] == 'environment'}
assert len(rows) == 344 and sum(float(r['area']) for r in rows) > 5247
squares = 0
for r in rows:
    f, e = whole.get(r['name'], (0, 0))
    error = float(r['environment_standard_error']) ** 2 + e ** 2
    assert float(r['environment_standard_error']) <= 3e-3
    squares += (float(r['environment']) - f) ** 2 / max(error, 1e-12)
# t of 7 degrees of freedom has a variance of 1.4, and rows have directions in common, so that twice as much is allowed.
assert squares / len(rows) < 2.8, squares / len(rows)
ups = [r for r in rows if r['name'].startswith('road')]
assert ups and all(float(r['environment_down']) == 0 for r in ups)
assert max(float(r['environment_down']) for r in rows if r['name'].startswith('building')) > 0.1
assert 'form_factors' not in js and 'form_factors' not in h5 and 'leak' not in h5 and 'leak' not in rows[0]
assert cells.GetArray('leak') is None and h5.attrs['only'] == 'environment' and 'row_sum' not in rows[0]
)");
  // A file with the environment alone makes no page.
  const Result page = run("report " + file("a.h5") + " -o " + file("a.html"));
  EXPECT_EQ(page.status, 2);
  EXPECT_NE(page.output.find("the environment of each row alone"), std::string::npos) << page.output;
}

TEST_F(EnvironmentProgram, UpSplitsThatOfAllFormFactors) {
  ASSERT_EQ(run("compute " + kStreet + "--by surface --up 0,0,3 --tolerance 1e-2" + outputs()).output, "");
  judge(R"(
assert 'leak' in rows[0] and len(rows) == 20 and ('road', 'pavement_east') not in entries
assert entries['road', 'environment:up'][0] == entries['road', 'environment'][0]
)");
  // If `up` is turned over, the upper part becomes the lower one.
  const auto shareOf = [&](const std::string& up) {
    return shownValue(run("compute " + kStreet + "--by surface --tolerance 1e-2 --up " + up).output, "horizon");
  };
  const std::string up = shareOf("0,0,1"), down = shareOf("0,0,-1");
  const auto numbersOf = [](const std::string& line) {
    std::pair<double, double> numbers;
    EXPECT_EQ(std::sscanf(line.c_str(), "%lf %% of all emitted radiation leaves the scene upwards, %lf %% downwards",
                          &numbers.first, &numbers.second),
              2)
        << line;
    return numbers;
  };
  // Both runs have a tolerance of 1e-2 for each row's environment. A share of all radiation is a mean over 20 rows, in
  // which errors cancel in part. So the shares of two runs differ by less than one per cent.
  EXPECT_NEAR(numbersOf(up).first, numbersOf(down).second, 1);
  EXPECT_NEAR(numbersOf(up).second, numbersOf(down).first, 1);
  EXPECT_GT(numbersOf(up).first, 2 * numbersOf(up).second);
}

TEST_F(EnvironmentProgram, SaysWhatItCannotDo) {
  const std::string only = "compute " + kStreet + "--only environment ";
  for (const std::string of_matrix : {"--from road", "--pair road lanes", "--relative 0.1", "--epsilon 0.1",
                                      "--balance", "--drop-below 0.1", "--engine exact", "--checkpoint a.ck"}) {
    const Result refused = run(only + of_matrix);
    EXPECT_EQ(refused.status, 2) << of_matrix;
    EXPECT_NE(refused.output.find("is of a matrix; leave it out with --only environment"), std::string::npos)
        << refused.output;
  }
  for (const std::string format : {"mtx", "npz", "html", "vwf"})
    EXPECT_EQ(run(only + "-o " + file("a." + format)).status, 2) << format;
  EXPECT_EQ(run(only + "-o - --format npz").status, 2);
  EXPECT_EQ(run(only + "--up 0,0,0").status, 2);
  EXPECT_EQ(run("plan " + kStreet + "--only environment").status, 2);
  EXPECT_EQ(run("compute " + kStreet + "--up 0,0,1 --pair road lanes").status, 2);
}

TEST_F(EnvironmentProgram, SaysWhetherTheGoalWasReached) {
  const std::string only = "compute " + kStreet + "--only environment ";
  const Result missed = run(only + "--tolerance 1e-7 --seconds 0.3 --json -o " + file("a.csv"));
  EXPECT_EQ(missed.status, 3) << missed.output;
  EXPECT_NE(missed.output.find("the goal was not reached: largest standard error"), std::string::npos);
  EXPECT_NE(missed.output.find("\"goal_reached\": false"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(file("a.csv")));
  const Result timed = run(only + "--seconds 0.3 --json");
  EXPECT_EQ(timed.status, 0);
  EXPECT_NE(timed.output.find("\"goal_reached\": true"), std::string::npos);
  const Result piped = run(only + "--tolerance 0.05 -o -");
  EXPECT_EQ(piped.output.substr(0, 36), "from,to,form_factor,standard_error\nr") << piped.output;
}

}  // namespace
}  // namespace viewpeel
