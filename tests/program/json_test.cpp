// Python's JSON reader accepts the output of every subcommand, and of every error.
#include <fmt/format.h>

#include "tests/support/program.h"
#include "tests/support/python.h"

namespace viewpeel {
namespace {

class Json : public Program {
 protected:
  // Runs the program, loads its stdout as `d`, and runs the assertions in Python.
  void expect(const std::string& arguments, int status, const std::string& assertions) const {
    const std::string command =
        fmt::format(VIEWPEEL_PROGRAM " {} --json >'{}' 2>'{}' </dev/null", arguments, file("out"), file("err"));
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), status) << arguments << readFile(file("err"));
    const PythonResult judged = runPython(
        folder_, "import json, csv, math\nd = json.loads(open('out', 'rb').read().decode('utf-8'))\n" + assertions);
    EXPECT_EQ(judged.status, 0) << arguments << "\n" << judged.output << readFile(file("out")).substr(0, 3000);
  }
};

constexpr const char* kOffice = VIEWPEEL_SCENES "/office.obj ";

TEST_F(Json, HoldsWhatTheFilesHold) {
  expect(fmt::format("compute {} --by surface --seed 7 --directions 40 --replicates 3 -o {}", kOffice, file("a.csv")),
         0,
         R"(
assert d['command'] == 'compute' and d['options']['seed'] == 7 and d['options']['by'] == 'surface', d['options']
assert d['version'] and 'compute' in d['command_line'] and d['warnings'] == [] and d['status'] == 0
assert d['plan']['directions'] == 40 and d['replicates'] == 3 and d['settings']['seed'] == 7
assert [f['name'].endswith('a.csv') and not f['replaced'] for f in d['files']] == [True]
names = [r['name'] for r in d['rows']]
assert len(names) == 18 == d['ids'] and abs(sum(r['area'] for r in d['rows']) - d['area']) < 1e-9 * d['area']
assert d['form_factors']['columns'] == ['from', 'to', 'form_factor', 'standard_error']
found = {(names[i], names[j]): (f, s) for i, j, f, s in d['form_factors']['entries']}
for r in d['rows']:
    for to in ('environment', 'leak'):
        if r[to] or r[to + '_standard_error']: found[r['name'], to] = (r[to], r[to + '_standard_error'])
lines = csv.DictReader(open('a.csv'))
written = {(r['from'], r['to']): (float(r['form_factor']), float(r['standard_error'])) for r in lines}
assert found == written, set(found.items()) ^ set(written.items())
assert len(found) > 250
)");
}

TEST_F(Json, HasIntervalsBalancedFormFactorsAndWarnings) {
  expect("compute " VIEWPEEL_SCENES "/cube.obj --epsilon 0.1 --balance", 0, R"(
assert d['form_factors']['columns'][4:] == ['lower', 'upper', 'balanced_form_factor']
assert all(low <= f <= high for _, _, f, _, low, high, _ in d['form_factors']['entries'])
assert d['guarantee']['epsilon'] == 0.1 and d['plan']['guarantee']['epsilon'] == 0.1
assert d['balanced']['largest'] < 1e-12 and d['closed'] == d['balanced']  # its older name
)");
  std::ofstream(file("twice.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no a\nf 1 2 3\no b\nf 1 2 3\no c\nf 1 4 2\n";
  expect("compute --directions 20 " + file("twice.obj"), 0, R"(
assert len(d['warnings']) >= 1 and 'there already' in d['warnings'][0], d['warnings']
for line in open('err').read().splitlines(): assert line.removeprefix('viewpeel: warning: ') in d['warnings'], line
assert [r.get('is_empty', False) for r in d['rows']].count(True) == 1
)");
}

TEST_F(Json, OfTheOtherCommands) {
  expect(fmt::format("plan {} --tolerance 1e-2 --replicates 8", kOffice), 0,
         "assert d['command'] == 'plan' and d['plan']['pair_lines']['lines'] > 0 and d['polygons'] == 576\n");
  expect("plan " VIEWPEEL_SCENES "/cube.obj --epsilon 0.1 --pair-lines off", 0,
         "assert d['plan']['guarantee']['most_blocks'] >= d['plan']['guarantee']['expected_blocks'] > 0\n");
  expect("plan " VIEWPEEL_SCENES "/cube.obj --directions 50", 0, "assert d['plan']['expected_seconds'] > 0\n");
  const std::string plates = "compute --quiet " VIEWPEEL_SCENES "/plates.obj --directions 20 --replicates 4 --part ";
  for (const char* part : {"1/2", "2/2"})
    ASSERT_EQ(run(fmt::format("{}{} --checkpoint {}.h5", plates, part, file(std::string(part, 1)))).status, 0);
  expect(fmt::format("merge {0}/1.h5 {0}/2.h5 -o {0}/m.h5", folder_.string()), 0, R"(
assert d['replicates'] == 8 and d['settings']['directions'] == 20 and len(d['form_factors']['entries']) == 2
assert d['files'][0]['name'].endswith('m.h5')
)");
  expect(fmt::format("report {0}/m.h5 -o {0}/m.html", folder_.string()), 0, "assert not d['files'][0]['replaced']\n");
  expect("check " VIEWPEEL_SCENES "/cube.obj --engine host --resolution 32 --directions 2 --lattices 16", 0,
         "assert d['passes'] is True and d['resolutions'][0]['resolution'] == 32\n");
  expect("devices", 0, "assert any(x['usable'] for x in d['devices'])\n");
  expect(fmt::format("solve {} --materials " VIEWPEEL_SCENES "/office_materials.csv --form-factors 1e-2", kOffice), 0,
         R"(
radiator = [r for r in d['heat']['rows'] if r['name'] == 'radiator'][0]
assert abs(radiator['heat_flow'] - 519) < 5 and radiator['temperature'] == 333.15
assert abs(d['heat']['balance_residual']) < 1e-6 and d['rows'] and d['form_factors']['entries'] and d['warnings']
)");
}

TEST_F(Json, OfErrors) {
  const std::string one_line = R"(
assert d['version'] and '\n' not in d['error'] and isinstance(d['warnings'], list)
assert open('err', errors='replace').read().endswith('viewpeel: ' + d['error'] + '\n') or '\ufffd' in d['error']
)";
  for (const char* arguments :
       {"compute nothing.obj", "compute", "comput x.obj", "compute " VIEWPEEL_SCENES "/cube.obj --zzz",
        "plan nothing.obj", "merge nothing.h5", "report nothing.h5 -o a.html", "check nothing.obj",
        "solve nothing.obj --materials nothing.csv", "compute " VIEWPEEL_SCENES "/cube.obj --quiet",
        "compute " VIEWPEEL_SCENES "/cube.obj --verbose", "compute 'no\xff\"thing.obj'", "devices 1"})
    expect(arguments, 2, one_line + "assert d['status'] == 2\n");
  expect("compute " VIEWPEEL_SCENES "/cube.obj --device nonsense", 1, one_line + "assert d['status'] == 1\n");
  expect("compute " VIEWPEEL_SCENES "/plates.obj --directions 20 --balance", 2,
         one_line + "assert 'balance' in d['error']\n");
  expect(fmt::format("compute {} --by surface --pair-lines off --replicates 2 --tolerance 1e-9 --seconds 0.5", kOffice),
         3, "assert d['goal_reached'] is False and d['status'] == 3 and d['form_factors']['entries']\n");
}

}  // namespace
}  // namespace viewpeel
