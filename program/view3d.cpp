#include "program/view3d.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include "formats/view3d_matrix.h"
#include "io/write_file.h"
#include "scene/read_vs3.h"
#include "stopwatch.h"

namespace viewpeel::program {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLogFile = "View3D.log";
constexpr double kLeastTolerance = 1e-5, kLargestTolerance = 1e-2;

// A Log collects the text of the log file, and prints some of it on stderr.
class Log {
 public:
  void note(const std::string& line) { text_ += line + "\n"; }
  void say(const std::string& line) {
    note(line);
    fmt::print(stderr, "{}\n", line);
  }
  void write() const {
    writeFile(kLogFile, [this](std::ostream& out) { out << text_; });
  }

 private:
  std::string text_;
};

double toleranceOf(const Vs3Control& control) { return std::clamp(control.eps, kLeastTolerance, kLargestTolerance); }

void noteControl(const Vs3File& file, Log& log) {
  const Vs3Control& control = file.control;
  log.note(fmt::format("\nTitle: {}\nout={} encl={:d} emit={:d} row={} col={} list={} maxD={}", file.title, control.out,
                       control.is_closed, control.has_emissivities, control.row, control.column, control.list,
                       control.largest_distance));
  log.note(fmt::format("eps={}: largest standard error {}", control.eps, toleranceOf(control)));
  const auto of_kind = [&](char kind) { return std::ranges::count(file.surfaces, kind, &Vs3Surface::kind); };
  log.note(fmt::format("surfaces: {} in all; {} S, {} M, {} N, {} O", file.surfaces.size(), of_kind('S'), of_kind('M'),
                       of_kind('N'), of_kind('O')));
}

Result compute(const Scene& scene, const Vs3Control& control, const Question& question, Log& log) {
  Request request;
  request.by = By::surface;
  request.goal = Tolerance{toleranceOf(control)};
  request.question = question;
  request.promise = false;  // View3D's files have no place for intervals
  Result result = computeFormFactors(scene, request);
  for (const std::string& warning : result.warnings) log.say("WARNING " + warning);
  log.say(fmt::format("{:.2f} seconds to compute form factors, largest standard error {:.1e}", result.seconds,
                      result.largest_standard_error));
  return result;
}

Scene build(const Vs3Scene& made, Log& log) {
  Scene scene = buildScene(made.input);
  for (const std::string& warning : scene.warnings) log.say("WARNING " + warning);
  return scene;
}

void computeAll(const Vs3File& file, const fs::path& output, Log& log) {
  const Vs3Control& control = file.control;
  const Vs3Scene made = makeScene(file);
  const Scene scene = build(made, log);
  std::vector<double> emissivities;
  for (const Vs3Surface& surface : file.surfaces)
    if (surface.hasRow()) emissivities.push_back(surface.emissivity);
  if (control.is_closed && !scene.blockers.empty())
    log.say("WARNING encl=1 beside surfaces that only block: rows are scaled to 1 without what these receive");
  const Result result = compute(scene, control, {}, log);
  View3dMatrix matrix = makeView3dMatrix(result.form_factors, emissivities);
  dropDistantPairs(matrix, file, made.surface_of);
  const std::vector<double> ones(matrix.rowCount(), 1.0);
  if (control.is_closed && !closeRows(matrix, ones))
    log.say("WARNING encl=1: rows cannot be scaled to 1; the surfaces are no enclosure");
  if (control.has_emissivities) {
    includeReflections(matrix);
    if (control.is_closed) closeRows(matrix, emissivities);
  }
  const View3dHeader header{control.out, control.is_closed, control.has_emissivities};
  writeFile(output, [&](std::ostream& out) {
    if (control.out == 0) writeView3dText(matrix, header, out);
    if (control.out == 1) writeView3dBinary(matrix, header, out);
    if (control.out == 2) writeView3dSparse(matrix, out);
  });
  if (control.list == 0) return;
  const std::vector<double> sums = sumRows(matrix);
  log.note("\nrow  area  row sum  name");
  for (uint32_t row = 0; row < matrix.rowCount(); ++row)
    log.note(fmt::format("{} {:g} {:.6f} {}", row + 1, matrix.areas[row], sums[row], made.input.surface_names[row]));
}

// Writes the form factors of one row, a line each, to all surfaces that are not merged into others. Where the file asks
// for a single column, its form factor goes only to the log.
void computeRow(const Vs3File& file, const fs::path& output, Log& log) {
  const Vs3Control& control = file.control;
  const auto indexOf = [&](uint32_t number, const char* what) {
    const Vs3Surface& surface = file.surfaces[number - 1];
    if (surface.kind == 'O' || surface.kind == 'N')
      throw Error(ErrorCode::bad_input,
                  fmt::format("{}:{}: {}={} only blocks; name another surface", file.file, surface.line, what, number));
    return number - 1;
  };
  const Vs3Scene made = makeScene(file, false);
  const Scene scene = build(made, log);
  const uint32_t row = made.surface_of[indexOf(control.row, "row")];
  Question question;
  question.from = {made.input.surface_names[row]};
  const Result result = compute(scene, control, question, log);
  const Ids& ids = result.form_factors.ids();
  const std::vector<uint32_t> rows = ids.rows();
  std::vector<double> to_surface(made.input.surface_names.size(), 0);
  const auto from = std::ranges::find(rows, row);
  if (from != rows.end())
    for (uint32_t id = 0; id < ids.count(); ++id)
      to_surface[rows[id]] = result.form_factors.formFactor(static_cast<uint32_t>(from - rows.begin()), id).value;
  if (control.column) {
    const double f = to_surface[made.surface_of[indexOf(control.column, "col")]];
    log.note(fmt::format("\nF[{}][{}] = {:.5e}", control.row, control.column, f));
    writeFile(output, [](std::ostream&) {});
    return;
  }
  std::vector<double> to_merged(file.surfaces.size(), 0);
  for (size_t k = 0; k < file.surfaces.size(); ++k) {
    const Vs3Surface& surface = file.surfaces[k];
    if (surface.kind == 'S' || surface.kind == 'M')
      to_merged[surface.merged_into ? surface.merged_into - 1 : k] += to_surface[made.surface_of[k]];
  }
  writeFile(output, [&](std::ostream& out) {
    for (size_t k = 0; k < file.surfaces.size(); ++k)
      if (file.surfaces[k].kind != 'O' && file.surfaces[k].merged_into == 0) fmt::print(out, "{:.5f}\n", to_merged[k]);
  });
}

void run(const fs::path& input, const fs::path& output, Log& log) {
  const Clock::time_point start = Clock::now();
  if (!fs::is_regular_file(input))
    throw Error(ErrorCode::bad_input, fmt::format("{}: no such file; check the name", input.string()));
  checkWritable(output);
  log.note(fmt::format("viewpeel {}, in the place of View3D\nData file:  {}\nOutput file:  {}", VIEWPEEL_VERSION,
                       input.string(), output.string()));
  const Vs3File file = parseVs3(input);
  noteControl(file, log);
  if (file.control.row) computeRow(file, output, log);
  else computeAll(file, output, log);
  log.say(fmt::format("{:.2f} seconds for all calculations", secondsSince(start)));
}

}  // namespace

bool isView3d(const char* name) {
  const std::string base = fs::path(name).filename().string();
  return base == "view3d" || base == "View3D";
}

int runView3d(int argc, char** argv) {
  if (argc != 3)
    throw Error(ErrorCode::bad_usage, "view3d takes two arguments, the .vs3 file to read and the file to write");
  checkWritable(kLogFile);
  Log log;
  try {
    run(argv[1], argv[2], log);
  } catch (const std::exception& error) {
    log.note(std::string("ERROR ") + error.what());
    log.write();
    throw;
  }
  log.write();
  return 0;
}

}  // namespace viewpeel::program
