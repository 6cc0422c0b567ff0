// readResult() returns the results that writeFormFactors() has stored in a .h5 file.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/read.h>
#include <viewpeel/write.h>
#include "io/read_report.h"
#include "scenes/named_scenes.h"
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;
namespace ts = test_scenes;

// Returns a scene in which a face without area makes rows differ from ids. "desk[2]" is the name of a face, and "solo"
// that of a surface of one face.
InputScene deskScene() {
  InputScene input{"desks", {}, {}};
  ts::addFace(input, "desk", {{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0}});
  ts::addFace(input, "desk", {{0, 0, 6}, {1, 0, 6}, {1, 0, 6}});
  ts::addFace(input, "desk", {{0, 0, 5}, {0, 1, 5}, {1, 1, 5}});
  ts::addFace(input, "solo", {{3, 0, 0}, {3, 0, 1}, {3, 1, 2}, {3, 2, 1}, {3, 2, 0}});
  ts::addFace(input, "wall", {{0, 4, 0}, {0.5, 4, 0}, {0.5, 4, 0.7}});
  return input;
}

class ReadResult : public TestFolder {
 protected:
  Scene scene_ = buildScene(deskScene());
  FormFactors form_factors_ = randomFormFactors(makeIds(scene_, By::polygon, false), 7, 0.7);
};

// The file stores F, and exchangeArea() is A F. This rounds twice, by 2^-53 of the value each.
void expectSame(double a, double b) { EXPECT_NEAR(a, b, 2 * 0x1p-52 * std::abs(b)); }

void expectSame(const FormFactors& read, const FormFactors& written) {
  const Ids &a = read.ids(), &b = written.ids();
  EXPECT_EQ(a.names, b.names);
  EXPECT_EQ(a.areas, b.areas);
  EXPECT_EQ(a.requested, b.requested);
  EXPECT_EQ(a.empty_rows, b.empty_rows);
  ASSERT_EQ(a.count(), b.count());
  for (uint32_t i = 0; i < a.count(); ++i) {
    if (!b.isRequested(i)) continue;
    EXPECT_EQ(read.rowSums()[i].value, written.rowSums()[i].value);
    for (uint32_t j = 0; j < a.count() + 2; ++j) {
      const uint32_t to = j == a.count() ? kEnvironment : j == a.count() + 1 ? kLeak : j;
      SCOPED_TRACE(testing::Message() << i << " to " << to);
      expectSame(read.formFactor(i, to).value, written.formFactor(i, to).value);
      expectSame(read.formFactor(i, to).standard_error, written.formFactor(i, to).standard_error);
      expectSame(read.interval(i, to).lower, written.interval(i, to).lower);
      expectSame(read.interval(i, to).upper, written.interval(i, to).upper);
    }
  }
}

TEST_F(ReadResult, BringsBackWhatWasWritten) {
  for (const bool with_geometry : {true, false}) {
    OutputContent content{form_factors_, nullptr, with_geometry ? &scene_ : nullptr, {{"seed", "7"}, {"rate", "0.25"}}};
    writeFormFactors(content, folder_ / "desks.h5");
    const StoredResult stored = readResult(folder_ / "desks.h5");
    expectSame(stored.form_factors, form_factors_);
    EXPECT_EQ(stored.surface_names, (std::vector<std::string>{"desk", "solo", "wall"}));
    EXPECT_EQ(stored.form_factors.ids().surface, (std::vector<uint32_t>{0, 0, 1, 2}));
    EXPECT_FALSE(stored.balanced);
    using Parameter = std::pair<std::string, std::string>;
    EXPECT_NE(std::ranges::find(stored.parameters, Parameter("seed", "7")), stored.parameters.end());
    EXPECT_NE(std::ranges::find(stored.parameters, Parameter("rate", "0.25")), stored.parameters.end());
  }
}

// A question leaves out rows. Only requested rows have form factors to the rows left out.
TEST_F(ReadResult, BringsBackTheRowsOfAQuestion) {
  Ids ids = form_factors_.ids();
  ids.requested = {false, true, false, true};
  const FormFactors some(ids, form_factors_.entries(), form_factors_.rowSums());
  writeFormFactors(some, folder_ / "some.h5");
  expectSame(readResult(folder_ / "some.h5").form_factors, some);
}

// The bound on pairs without an entry is stored as well.
TEST_F(ReadResult, BringsBackIntervalsAndBalancedFormFactors) {
  std::vector<Interval> intervals;
  for (const FormFactors::Entry& entry : form_factors_.entries())
    intervals.push_back({0.5 * entry.exchange_area.value, 2 * entry.exchange_area.value});
  const FormFactors bounded(form_factors_.ids(), form_factors_.entries(), form_factors_.rowSums(), intervals, 0.125);
  writeFormFactors(OutputContent{bounded, &form_factors_}, folder_ / "bounded.h5");
  const StoredResult stored = readResult(folder_ / "bounded.h5");
  expectSame(stored.form_factors, bounded);
  EXPECT_EQ(stored.form_factors.unlistedBound(), 0.125);
  ASSERT_TRUE(stored.balanced);
  EXPECT_EQ(stored.balanced->entries().size(), stored.form_factors.entries().size());
  for (uint32_t j = 0; j < form_factors_.ids().count(); ++j)
    expectSame(stored.balanced->formFactor(1, j).value, form_factors_.formFactor(1, j).value);
}

// The result of a run is read back, with whole rows.
TEST_F(ReadResult, BringsBackARun) {
  const Scene scene = buildScene(ts::parallelSquares());
  Request request;
  request.engine = EngineKind::host;
  FormFactorRun run(scene, request);
  while (!run.isDone()) run.step();
  const Result result = run.result();
  writeFormFactors({result.form_factors, nullptr, &scene, parametersOf(run, result)}, folder_ / "run.h5");
  const StoredResult stored = readResult(folder_ / "run.h5");
  expectSame(stored.form_factors, result.form_factors);
  EXPECT_TRUE(stored.form_factors.ids().rows_sum_to_one);
  EXPECT_FALSE(stored.form_factors.ids().two_sided);
}

// A result that was read can be written and read again. The attributes that the writer adds to every file are then
// among the attributes that were read, which must do no harm.
TEST_F(ReadResult, CanBeWrittenAgain) {
  std::vector<Interval> intervals;
  for (const FormFactors::Entry& entry : form_factors_.entries())
    intervals.push_back({0.5 * entry.exchange_area.value, 2 * entry.exchange_area.value});
  const FormFactors bounded(form_factors_.ids(), form_factors_.entries(), form_factors_.rowSums(), intervals, 0.125);
  writeFormFactors({bounded, nullptr, &scene_, {{"seed", "7"}}}, folder_ / "once.h5");
  const StoredResult once = readResult(folder_ / "once.h5");
  writeFormFactors({once.form_factors, nullptr, nullptr, once.parameters}, folder_ / "again.h5");
  const StoredResult again = readResult(folder_ / "again.h5");
  EXPECT_EQ(again.parameters, once.parameters);
  expectSame(again.form_factors, once.form_factors);
}

TEST_F(ReadResult, RefusesOtherFiles) {
  const auto refusal = [](const fs::path& file) {
    try {
      readResult(file);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_NE(refusal(folder_ / "absent.h5").find("cannot be read"), std::string::npos);
  std::ofstream(folder_ / "text.h5") << "from,to,form_factor\n";
  EXPECT_NE(refusal(folder_ / "text.h5").find("not a whole result"), std::string::npos);
  writeFormFactors(form_factors_, folder_ / "whole.h5");
  std::ifstream whole(folder_ / "whole.h5", std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  for (const size_t at : {size_t(0), bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    std::ofstream(folder_ / "damaged.h5", std::ios::binary) << damaged;
    EXPECT_NE(refusal(folder_ / "damaged.h5").find("not a whole result"), std::string::npos) << at;
  }
  const Scene scene = buildScene(ts::parallelSquares());
  Request request;
  request.engine = EngineKind::host;
  request.goal = FixedAmount{.directions = 8, .replicates = 2};
  FormFactorRun run(scene, request);
  run.step();
  run.writeCheckpoint(folder_ / "run.h5");
  EXPECT_NE(refusal(folder_ / "run.h5").find("checkpoint"), std::string::npos);
}

// An Edit changes a file by h5py, and then renews the check sum of host/io/hdf5_output.h. `why` is the message of the
// refusal. `is_shown` is false where a page does not read the changed data.
struct Edit {
  const char *code, *why;
  bool is_shown = true;
};
const Edit kEdits[] = {
    {"f.attrs['unlisted_bound'] = 'text'", "no number 'unlisted_bound'", false},
    {"f.attrs['unlisted_bound'] = '0.1x'", "no number 'unlisted_bound'", false},
    {"f.attrs['unlisted_bound'] = -1.0", "no number 'unlisted_bound'", false},
    {"del f.attrs['unlisted_bound']", "no number 'unlisted_bound'", false},
    {"del f.attrs['viewpeel_result_format']", "it is another file"},
    {"f.attrs['viewpeel_result_format'] = 2", "of another format"},
    {"del f['name']", "no readable 'name'"},
    {"del f['name']; f['name'] = 7", "'name' is of another kind"},
    {"f['area'][0] = -1", "no areas"},
    {"f['area'][0] = float('inf')", "no areas"},
    {"f['area'][0] = float('nan')", "'area' has values that are no numbers"},
    {"f['area'][0] = 0", "an empty row has", false},
    {"del f['area']; f['area'] = [1.0, 2.0]", "'area' has 2 values for 5"},
    {"del f['area']; f['area'] = [[1.0] * 5]", "'area' is of another kind"},
    {"del f['area']; f['area'] = numpy.ones(5, 'f4')", "'area' is of another kind"},
    {"del f['area']; f.create_group('area')", "no readable 'area'"},
    {"f['form_factors/indptr'][1] = 99", "rows are not in order"},
    {"f['form_factors/indptr'][0] = -1", "rows are not in order"},
    {"f['form_factors/indices'][0] = 5", "'form_factors/indices' has 5"},
    {"f['form_factors/indices'][0] = -1", "'form_factors/indices' has -1"},
    {"f['form_factors/data'][0] = float('nan')", "no numbers"},
    {"f['upper_bounds/data'][0] = float('nan')", "no numbers"},
    {"f['leak'][1] = float('nan')", "'leak' has values that are no numbers"},
    {"f['geometry/row_of_polygon'][0] = 5", "'geometry/row_of_polygon' has 5"},
    {"f['geometry/surface_of_polygon'][0] = -2", "'geometry/surface_of_polygon' has -2"},
    {"f['geometry/first_corner'][0] = 99", "'geometry/first_corner' has 99"},
    {"f['geometry/corner_count'][0] = 2", "do not agree with its list of corners"},
};

// Readers refuse such files with status 2 and one line that names file, fault and remedy.
TEST_F(ReadResult, RefusesColumnsThatDoNotFit) {
  std::vector<Interval> intervals;
  for (const FormFactors::Entry& entry : form_factors_.entries())
    intervals.push_back({0.5 * entry.exchange_area.value, 2 * entry.exchange_area.value});
  const FormFactors bounded(form_factors_.ids(), form_factors_.entries(), form_factors_.rowSums(), intervals, 0.125);
  writeFormFactors(OutputContent{bounded, nullptr, &scene_}, folder_ / "whole.h5");
  std::string script = R"(
import shutil, h5py, numpy
def finish(name):
    # The check sum stands behind HDF5's own end: of words of 8 bytes, little-endian.
    with open(name, 'rb') as file:
        content = file.read()
    value, mask = 0x243F6A8885A308D3, 2**64 - 1
    for word in numpy.frombuffer(content + bytes(-len(content) % 8), '<u8').tolist():
        value = ((value ^ word) * 0x9E3779B97F4A7C15) & mask
        value ^= value >> 32
    with open(name, 'ab') as file:
        file.write(value.to_bytes(8, 'little'))
def edit(name, code):
    shutil.copy('whole.h5', name)
    with h5py.File(name, 'r+') as f:
        exec(code)
    finish(name)
edit('same.h5', 'pass')
)";
  for (size_t k = 0; k < std::size(kEdits); ++k) script += fmt::format("edit('{}.h5', \"{}\")\n", k, kEdits[k].code);
  const PythonResult made = runPython(folder_, script);
  ASSERT_EQ(made.status, 0) << made.output;
  expectSame(readResult(folder_ / "same.h5").form_factors, bounded);
  for (size_t k = 0; k < std::size(kEdits); ++k) {
    const fs::path file = folder_ / fmt::format("{}.h5", k);
    const std::string said = refusalOf([&] { readResult(file); });
    EXPECT_TRUE(said.starts_with(file.string() + ": not a whole result: ")) << kEdits[k].code << said;
    EXPECT_NE(said.find(kEdits[k].why), std::string::npos) << kEdits[k].code << ": " << said;
    EXPECT_TRUE(said.ends_with("; take a .h5 that viewpeel wrote, or write it anew")) << said;
    EXPECT_EQ(refusalOf([&] { readReport(file); }), kEdits[k].is_shown ? said : "none") << kEdits[k].code;
  }
}

}  // namespace
}  // namespace viewpeel
