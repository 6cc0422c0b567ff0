// These tests use outputs as daily work does: fewer entries, pipes, names for faces, summed parts, another place on a
// full disk.
#include <fstream>

#include <fmt/format.h>

#include "tests/support/program.h"
#include "tests/support/python.h"

namespace viewpeel {
namespace {

const std::string kOffice = VIEWPEEL_SCENES "/office.obj ";

class DailyUse : public Program {
 protected:
  // Runs Python with assertions. `vp` is the program's path, `office` the path of a scene.
  void judge(const std::string& script) const {
    const PythonResult judged =
        runPython(folder_, fmt::format("import csv, json, math, os, subprocess, sys\nvp = '{}'\noffice = '{}'\n",
                                       VIEWPEEL_PROGRAM, VIEWPEEL_SCENES "/office.obj") +
                               script);
    EXPECT_EQ(judged.status, 0) << judged.output;
  }
};

// A scene of two files gives the bytes of the same scene in one file, from every command that reads a scene.
TEST_F(DailyUse, SeveralFilesAreOneScene) {
  const std::string low = "o low\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
                    high = "o high\nv 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\n";
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(file(name)) << text; };
  write("low.obj", low), write("high.obj", high + "f 1 2 3 4\n"), write("both.obj", low + high + "f 5 6 7 8\n");
  write("materials.csv", "surface,emissivity,temperature,heat_flux\ndefault,0.8,300,\nenvironment,,200,\n");
  const std::string parts = file("low.obj") + " " + file("high.obj"), both = file("both.obj");
  const std::string options = " --quiet --directions 64 --checkpoint ";
  ASSERT_EQ(run("compute " + both + options + file("both.h5") + " -o " + file("both.csv")).status, 0);
  ASSERT_EQ(run(parts + options + file("parts.h5") + " -o " + file("parts.csv")).status, 0);
  EXPECT_EQ(readFile(file("parts.csv")), readFile(file("both.csv")));
  // Checkpoints of the one go on with the other, and know another order.
  EXPECT_EQ(run("compute " + both + options + file("parts.h5") + " --resume --replicates 9").status, 0);
  const std::string of_parts = " --scene " + file("low.obj") + " --scene " + file("high.obj"),
                    turned = " --scene " + file("high.obj") + " --scene " + file("low.obj");
  EXPECT_EQ(run("merge --quiet " + file("both.h5") + of_parts + " -o " + file("merged.vtp")).status, 0);
  const Result refused = run("merge --quiet " + file("both.h5") + turned + " -o " + file("merged.vtp"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.output.find("high.obj, low.obj: another scene than that of"), std::string::npos) << refused.output;
  EXPECT_EQ(run("plan " + parts).status, 0);
  EXPECT_EQ(run("check " + parts + " --directions 4").status, 0);
  const std::string heat = " --materials " + file("materials.csv") + " --quiet -o ";
  ASSERT_EQ(run("solve " + parts + heat + file("parts_heat.csv")).status, 0);
  ASSERT_EQ(run("solve " + both + heat + file("both_heat.csv")).status, 0);
  EXPECT_EQ(readFile(file("parts_heat.csv")), readFile(file("both_heat.csv")));
}

TEST_F(DailyUse, DroppedFormFactorsAreAddedUpInEachRow) {
  const std::string run_of = "compute " + kOffice + "--by surface --directions 40 --replicates 4 --quiet ";
  ASSERT_EQ(run(fmt::format("{} -o {}", run_of, file("whole.csv"))).output, "");
  ASSERT_EQ(run(fmt::format("{} --drop-below 0.01 -o {} -o {} -o {} -o {}", run_of, file("less.csv"),
                            file("less.rows.csv"), file("less.h5"), file("less.json")))
                .output,
            "");
  judge(R"(
import h5py
def read(name): return {(r['from'], r['to']): float(r['form_factor']) for r in csv.DictReader(open(name))}
whole, less = read('whole.csv'), read('less.csv')
gone = {key: f for key, f in whole.items() if key not in less}
assert all(whole[key] == f for key, f in less.items()) and len(gone) > 20, len(gone)
for (i, j), f in gone.items(): assert f < 0.01 and whole[j, i] < 0.01 and j not in ('environment', 'leak')
for (i, j), f in less.items(): assert f >= 0.01 or j in ('environment', 'leak') or less[j, i] >= 0.01
rows = list(csv.DictReader(open('less.rows.csv')))
assert [r['row'] for r in rows] == [str(k + 1) for k in range(18)]
h5, js = h5py.File('less.h5'), json.load(open('less.json'))
for k, r in enumerate(rows):
    lost = sum(f for (i, j), f in gone.items() if i == r['name'])
    for dropped in (float(r['dropped']), h5['dropped'][k], js['rows'][k]['dropped']): assert abs(dropped - lost) < 1e-15
    total = sum(f for (i, j), f in less.items() if i == r['name']) + lost
    assert abs(total - float(r['row_sum'])) < 1e-12
assert h5.attrs['drop_below'] == 0.01 and 'faces' in h5.attrs['row_order'] and 'faces' in js['row_order']
)");
  const Result said = run("compute " + kOffice + "--by surface --directions 40 --drop-below 0.01");
  EXPECT_NE(said.output.find("\ndropped    "), std::string::npos) << said.output;
  EXPECT_EQ(run("compute " + kOffice + "--drop-below 0.01 --balance").status, 2);
}

// Numbers that a sparse matrix cannot hold go to files beside it.
TEST_F(DailyUse, RowsAndErrorsHaveFilesOfTheirOwn) {
  ASSERT_EQ(
      run(fmt::format("compute {} --by surface --directions 40 --quiet -o {} -o {} -o {} -o {} -o {}", kOffice,
                      file("a.csv"), file("a.rows.csv"), file("a.npz"), file("a.errors.npz"), file("a.errors.mtx")))
          .output,
      "");
  judge(R"(
import scipy.sparse, scipy.io
rows = list(csv.DictReader(open('a.rows.csv')))
names = [r['name'] for r in rows]
F, s = scipy.sparse.load_npz('a.npz').toarray(), scipy.sparse.load_npz('a.errors.npz').toarray()
m = scipy.io.mmread('a.errors.mtx').toarray()
assert (s == m).all() and s.max() > 0
for r in csv.DictReader(open('a.csv')):
    i = names.index(r['from'])
    if r['to'] in names:
        j = names.index(r['to'])
        assert F[i, j] == float(r['form_factor']) and s[i, j] == float(r['standard_error'])
    else:
        assert rows[i][r['to']] == r['form_factor'] and rows[i][r['to'] + '_standard_error'] == r['standard_error']
for i, r in enumerate(rows):
    beside = [float(r['environment_standard_error']), float(r['leak_standard_error'])]
    assert float(r['largest_standard_error']) == max(list(s[i]) + beside)
assert float(rows[0]['area']) > 0 and '% rows and columns stand in the order' in open('a.errors.mtx').read()
)");
}

TEST_F(DailyUse, StandardOutputTakesAResult) {
  const std::string run_of = "compute " + kOffice + "--by surface --directions 20 ";
  for (const char* format : {"csv", "rows.csv", "mtx", "npz", "json"}) {
    ASSERT_EQ(run(fmt::format("{} --quiet -o {}", run_of, file(std::string("a.") + format))).output, "");
    const std::string piped = fmt::format(VIEWPEEL_PROGRAM " {} -o - --format {} 2>'{}' | cat >'{}'", run_of, format,
                                          file("err"), file("piped"));
    ASSERT_EQ(std::system(piped.c_str()), 0);
    EXPECT_TRUE(std::string(format) == "json" || readFile(file("piped")) == readFile(file(std::string("a.") + format)));
    EXPECT_EQ(readFile(file("err")), "");
  }
  judge(
      "a, b = json.load(open('a.json')), json.load(open('piped'))\n"
      "assert a['form_factors'] == b['form_factors'] and a['rows'] == b['rows'] and len(b['rows']) == 18\n");
  for (const char* wrong : {"-o - -o -", "--format csv", "-o - --json", "-o - --format xyz"})
    EXPECT_EQ(run(run_of + wrong).status, 2) << wrong;
}

TEST_F(DailyUse, GroupsNameTheFacesOfABinaryFile) {
  judge(R"(
import struct
def facet(a, b, c): return struct.pack('<12fH', 0, 0, 0, *a, *b, *c, 0)
low = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
high = [(x, y, 1) for x, y, _ in low]
facets = [facet(low[0], low[1], low[2]), facet(low[0], low[2], low[3])]
facets += [facet(high[2], high[1], high[0]), facet(high[3], high[2], high[0])]
open('plates.stl', 'wb').write(b' ' * 80 + struct.pack('<I', 4) + b''.join(facets))
open('groups.csv', 'w').write('face,name\n1-2,lower\n3,upper\n4,upper\n')
def run(*more): return subprocess.run([vp, *more], capture_output=True, text=True)
options = ['--groups', 'groups.csv', '--by', 'surface', '--tolerance', '1e-3', '--quiet', '-o', 'a.csv']
r = run('compute', 'plates.stl', *options)
assert r.returncode == 0, r.stderr
rows = {(r['from'], r['to']): float(r['form_factor']) for r in csv.DictReader(open('a.csv'))}
assert abs(rows['lower', 'upper'] - 0.199825) < 4e-3, rows  # unit squares at distance 1
open('groups.csv', 'a').write('9,upper\n')
r = run('compute', 'plates.stl', '--groups', 'groups.csv')
said = 'viewpeel: groups.csv:5: there is no face 9; the scene has faces 1 to 4\n'
assert r.returncode == 2 and r.stderr == said, r.stderr
)");
}

// `plan` takes the same options as `compute`, so a command line can be tried first.
TEST_F(DailyUse, PlanTakesTheOptionsOfCompute) {
  const std::string options = fmt::format(
      "{} --by surface --directions 40 --replicates 4 --balance --closure --show floor --drop-below 0 "
      "--checkpoint {} --resume --checkpoint-seconds 5 -o {} -o {} ",
      kOffice, file("c.h5"), file("a.csv"), file("a.vtp"));
  const Result planned = run("plan " + options);
  EXPECT_EQ(planned.status, 0) << planned.output;
  EXPECT_NE(planned.output.find("not there yet, starts afresh"), std::string::npos) << planned.output;
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  for (const char* talk : {"--quiet", "--verbose", "--json"})
    EXPECT_EQ(run("plan " + options + talk).status, 0) << talk;
  EXPECT_EQ(run("plan " + kOffice + "-o " + file("none/a.csv")).status, 2);
  EXPECT_EQ(run("plan " + kOffice + "--show nothing -o " + file("a.vtp")).status, 2);
  ASSERT_EQ(run("compute " + options + "--quiet").status, 0);
  const Result again = run("plan " + options);
  EXPECT_NE(again.output.find("goes on after replicates 0 to 3"), std::string::npos) << again.output;
}

TEST_F(DailyUse, OlderNameOfTheBalancedMatrixIsWritten) {
  ASSERT_EQ(run(fmt::format("compute {} --by surface --directions 40 --quiet --closure -o {}", kOffice, file("a.mtx")))
                .output,
            "");
  EXPECT_TRUE(std::filesystem::exists(file("a.balanced.mtx")));
  judge("import scipy.io\nassert (scipy.io.mmread('a.closed.mtx') != scipy.io.mmread('a.balanced.mtx')).nnz == 0\n");
}

TEST_F(DailyUse, MergeAddsToACheckpoint) {
  const std::string part = "compute " + kOffice + "--by surface --directions 20 --replicates 2 --quiet --part ";
  for (int k = 1; k <= 3; ++k)
    ASSERT_EQ(run(fmt::format("{}{}/3 --checkpoint {}", part, k, file(fmt::format("{}.h5", k)))).output, "");
  const std::string all = file("all.h5");
  ASSERT_EQ(run(fmt::format("merge --quiet {} --checkpoint {} --resume", file("1.h5"), all)).output, "");
  EXPECT_EQ(run(fmt::format("merge --quiet {} --checkpoint {}", file("2.h5"), all)).status, 2);
  ASSERT_EQ(run(fmt::format("merge --quiet {} {} --checkpoint {} --resume -o {}", file("3.h5"), file("2.h5"), all,
                            file("a.csv")))
                .output,
            "");
  ASSERT_EQ(
      run(fmt::format("merge --quiet {} {} {} -o {}", file("1.h5"), file("2.h5"), file("3.h5"), file("b.csv"))).output,
      "");
  EXPECT_TRUE(readFile(file("a.csv")) == readFile(file("b.csv")));
  // Replicates that the file already has count once.
  ASSERT_EQ(
      run(fmt::format("merge --quiet {} --checkpoint {} --resume -o {}", file("3.h5"), all, file("c.csv"))).output, "");
  EXPECT_TRUE(readFile(file("c.csv")) == readFile(file("b.csv")));
  EXPECT_EQ(run(fmt::format("merge {} --resume", all)).status, 2);
}

// A limit on the size of files simulates a full disk, where a smaller file still fits.
TEST_F(DailyUse, AFullDiskAsksForAnotherPlaceOnATerminal) {
  judge(R"(
import pty
options = [vp, 'compute', office, '--by', 'surface', '--directions', '20', '-o', 'large.csv']
limited = ['sh', '-c', "trap '' XFSZ; ulimit -f 20; exec \"$@\"", 'sh']
def talk(command, answer):
    pid, terminal = pty.fork()
    if pid == 0: os.execvp(command[0], command)
    text, answered = b'', False
    while True:
        try: more = os.read(terminal, 4096)
        except OSError: break
        if not more: break
        text += more
        if not answered and b'write it to' in text:
            os.write(terminal, answer)
            answered = True
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), text.decode()
status, text = talk(limited + options, b'small.npz\n')
assert status == 0 and 'large.csv: cannot write: File too large' in text, (status, text)
assert 'written to small.npz' in text, text
assert os.path.exists('small.npz') and not os.path.exists('large.csv')
status, text = talk(limited + options, b'\n')
assert status == 1 and 'the result was not written' in text, (status, text)
# Without a terminal it is one line, with what to do.
r = subprocess.run(limited + options + ['--quiet'], stdin=subprocess.DEVNULL, capture_output=True, text=True)
assert r.returncode == 1 and r.stderr.count('\n') == 1, r
assert 'a run with --checkpoint keeps what was counted' in r.stderr, r
run = [vp, 'compute', office, '--directions', '20', '--unoccluded', 'off', '--quiet']
subprocess.run(run + ['-o', 'free.csv', '--checkpoint', 'free.h5'], check=True)
between = (os.path.getsize('free.csv') + os.path.getsize('free.h5')) // 2 // 512
limited = ['sh', '-c', f"trap '' XFSZ; ulimit -f {between}; exec \"$@\"", 'sh']
r = subprocess.run(limited + run + ['-o', 'large.csv', '--checkpoint', 'c.h5'],
                   stdin=subprocess.DEVNULL, capture_output=True, text=True)
assert r.returncode == 1 and r.stderr.count('\n') == 1, r
assert 'c.h5 has what was counted: viewpeel merge c.h5 -o FILE' in r.stderr, r
subprocess.run([vp, 'merge', 'c.h5', '-o', 'later.csv', '--quiet'], check=True)
assert open('later.csv').read() == open('free.csv').read()
)");
}

TEST_F(DailyUse, ProgressFitsATerminalAndALog) {
  judge(R"(
import pty, re
command = [vp, 'compute', office, '--by', 'surface', '--tolerance', '2e-3', '--pair-lines', 'off', '-o', 'a.csv']
command += ['--unoccluded', 'on']
def show(**environment):
    pid, terminal = pty.fork()
    if pid == 0: os.execvpe(command[0], command, {**os.environ, 'TERM': 'xterm', **environment})
    text = b''
    while True:
        try: more = os.read(terminal, 4096)
        except OSError: break
        if not more: break
        text += more
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0, text
    return text.decode()
text = show()
lines = [re.sub('\x1b\\[[0-9;]*[mK]', '', line) for line in re.findall('\r\x1b\\[K([^\r\n]*)', text)]
phases = ('reading', 'pilot', 'unoccluded form factors,', 'counting', 'writing')
assert all(len(line) < 80 for line in lines if line.startswith(phases)), lines  # nor does the summary follow one
for phase in phases: assert any(line.startswith(phase) for line in lines), (phase, lines)
assert any(re.match(r'counting +\d+ %, .* left; replicate \d+ of about \d+', line) for line in lines), lines
assert '\x1b[32m' in text and '\x1b[32m' not in show(NO_COLOR='1')
often = {**os.environ, 'VIEWPEEL_PROGRESS_SECONDS': '0.05'}
log = subprocess.run(command, capture_output=True, text=True, env=often).stderr
assert len(log.splitlines()) > 2 and all(line.startswith('viewpeel: ') for line in log.splitlines()), log
assert '\x1b' not in log and 'viewpeel: counting' in log
assert subprocess.run(command, capture_output=True, text=True).stderr == ''  # shorter than a minute
)");
}

// A run that the plan gives no time for says how long it takes, once it has counted for a second: one of many
// replicates, and one that goes on to a finer goal with directions of an earlier run.
TEST_F(DailyUse, LongRunsSayHowLongTheyTake) {
  judge(R"(
import re, signal
def predicted(*words):
    with subprocess.Popen([vp, 'compute', office, *words], stdout=subprocess.PIPE, text=True) as running:
        line = next(line for line in running.stdout if line.startswith('expected'))
        running.send_signal(signal.SIGINT)
    return line
line = predicted('--by', 'surface', '--directions', '300', '--replicates', '1e6')
assert re.fullmatch(r'expected   1000000 replicates in all, \S+ (minutes|hours|days) more\n', line), line
coarse = ['--directions', '64', '--resolution', '64', '--checkpoint', 'coarse.h5']
subprocess.run([vp, 'compute', office, *coarse, '--replicates', '20', '-q'], check=True)
line = predicted(*coarse[-2:], '--resume')
assert re.fullmatch(r'expected   about \d+00 replicates in all, \S+ (s|minutes|hours) more\n', line), line
)");
}

}  // namespace
}  // namespace viewpeel
