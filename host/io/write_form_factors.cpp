#include <viewpeel/write.h>

#include <array>

#include <fmt/compile.h>
#include <fmt/ostream.h>

#include <viewpeel/error.h>
#include "io/entry_rows.h"
#include "io/shown_rows.h"
#include "io/write_file.h"
#include "io/writers.h"
#include "report/write_page.h"
#include "scene/foam_case.h"

namespace viewpeel {
namespace {

// Messages list the formats in this order. Elmer's text and bytes have the same extension: a file whose name ends in
// .bin.dat has bytes.
enum class Format {
  csv,
  rows,
  mtx,
  mtx_errors,
  npz_errors,
  npz,
  h5,
  json,
  vtp,
  vwf,
  html,
  idf,
  epjson,
  fdf,
  dat,
  moose,
  foam
};
constexpr std::array<std::pair<const char*, Format>, 13> kExtensions = {{{".csv", Format::csv},
                                                                         {".mtx", Format::mtx},
                                                                         {".npz", Format::npz},
                                                                         {".h5", Format::h5},
                                                                         {".json", Format::json},
                                                                         {".vtp", Format::vtp},
                                                                         {".vwf", Format::vwf},
                                                                         {".html", Format::html},
                                                                         {".idf", Format::idf},
                                                                         {".epJSON", Format::epjson},
                                                                         {".fdf", Format::fdf},
                                                                         {".dat", Format::dat},
                                                                         {".i", Format::moose}}};

Format formatOf(const std::filesystem::path& file) {
  std::error_code failure;
  if (std::filesystem::is_directory(file, failure) && isFoamCase(file)) return Format::foam;
  const std::string end = file.stem().extension().string() + file.extension().string();
  if (end == ".rows.csv") return Format::rows;
  if (end == ".errors.mtx") return Format::mtx_errors;
  if (end == ".errors.npz") return Format::npz_errors;
  for (const auto& [extension, format] : kExtensions)
    if (file.extension() == extension) return format;
  throw Error(ErrorCode::bad_usage,
              fmt::format("{}: unknown output format; use a name that ends in .csv, .mtx, .npz, "
                          ".h5, .json, .vtp, .html, .vwf, .idf, .epJSON, .fdf, .dat or .i, or the "
                          "folder of an OpenFOAM case",
                          file.string()));
}

bool isBuilding(Format format) { return format == Format::idf || format == Format::epjson; }

// Returns a matrix of the standard errors of all entries.
FormFactors errorsOf(const FormFactors& form_factors) {
  std::vector<FormFactors::Entry> entries = form_factors.entries();
  for (FormFactors::Entry& entry : entries) entry.exchange_area.value = entry.exchange_area.standard_error;
  return {form_factors.ids(), std::move(entries), form_factors.rowSums()};
}

// Returns whether balanced form factors go to a file beside the first.
bool hasBalancedFile(Format format) { return format == Format::mtx || format == Format::npz; }

void writeAs(Format format, const OutputContent& content, const std::filesystem::path& file, std::ostream& out) {
  if (format == Format::csv) writeCsv(content, out);
  if (format == Format::rows) writeRows(content, out);
  if (format == Format::mtx) writeMatrixMarket(content.form_factors, out);
  if (format == Format::mtx_errors) writeMatrixMarket(errorsOf(content.form_factors), out, "standard errors");
  if (format == Format::npz) writeNpz(content.form_factors, out);
  if (format == Format::npz_errors) writeNpz(errorsOf(content.form_factors), out);
  if (format == Format::h5) writeHdf5(content, out);
  if (format == Format::json) writeJson(content, out);
  if (format == Format::vtp) writeVtp(content, out);
  if (format == Format::vwf) writeVwf(content, out);
  const FormFactors& one = content.balanced ? *content.balanced : content.form_factors;
  if (isBuilding(format)) writeEnergyPlus(content, format == Format::epjson, out);
  if (format == Format::fdf) writeSyrthes(one, out);
  if (format == Format::dat) writeElmer(one, file.stem().extension() == ".bin", out);
  if (format == Format::moose) writeMoose(one, out);
  if (format == Format::html) writeHtml(content, file, out);
}

void requireContent(const std::filesystem::path& file, bool has_scene) {
  if (formatOf(file) == Format::html) requirePage(file.string());
  if (formatOf(file) == Format::vtp && !has_scene)
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: has the polygons, too; give the scene by --scene, or write .h5", file.string()));
}

}  // namespace

void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out, const char* what) {
  const Ids& ids = form_factors.ids();
  uint64_t nonzeros = 0;
  const EntryRows entries(form_factors);
  entries.forEach([&](const RowEntry& entry) { nonzeros += entry.j < kEnvironment; });
  fmt::print(out,
             "%%MatrixMarket matrix coordinate real general\n% {}; per row: number, area, environment share, name\n"
             "% rows and columns stand in the order of the scene file's faces, or with --by surface of its surfaces\n",
             what);
  const std::vector<uint32_t> rows = ids.rows();
  auto empty = ids.empty_rows.begin();
  const auto writeEmptyBefore = [&](uint32_t row) {
    for (; empty != ids.empty_rows.end() && empty->row < row; ++empty)
      fmt::print(out, "% {} 0 0 {}\n", empty->row + 1, empty->name);
  };
  for (uint32_t i = 0; i < ids.count(); ++i) {
    writeEmptyBefore(rows[i]);
    fmt::print(out, "% {} {} {} {}\n", rows[i] + 1, ids.areas[i], form_factors.formFactor(i, kEnvironment).value,
               ids.names[i]);
  }
  writeEmptyBefore(ids.rowCount());
  fmt::print(out, "{} {} {}\n", ids.rowCount(), ids.rowCount(), nonzeros);
  printEntries(entries, out, [&](const RowEntry& entry, fmt::memory_buffer& text) {
    if (entry.j < kEnvironment)
      fmt::format_to(fmt::appender(text), FMT_COMPILE("{} {} {}\n"), rows[entry.i] + 1, rows[entry.j] + 1,
                     entry.form_factor.value);
  });
}

void writeFormFactors(const OutputContent& content, const std::filesystem::path& file) {
  const Format format = formatOf(file);
  requireContent(file, content.scene != nullptr);
  if (content.has_environment_alone) checkEnvironmentOutput(file);
  if (isBuilding(format)) requireBuilding(file, content.scene);
  if (format == Format::moose) checkMooseRows(file, content.form_factors.ids());
  if (format == Format::foam) return writeFoam(content, file);
  writeFile(file, [&](std::ostream& out) { writeAs(format, content, file, out); });
  if (!content.balanced || !hasBalancedFile(format)) return;
  writeFile(filesOf(file, true)[1], [&](std::ostream& out) {
    if (format == Format::mtx) writeMatrixMarket(*content.balanced, out, "balanced form factors");
    else writeNpz(*content.balanced, out);
  });
}

void writeFormFactors(const OutputContent& content, std::ostream& out, const std::string& format) {
  const std::filesystem::path file = "output." + format;
  requireContent(file, content.scene != nullptr);
  if (content.has_environment_alone) checkEnvironmentOutput(file);
  writeAs(formatOf(file), content, file, out);
}

void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file, const FormFactors* balanced) {
  writeFormFactors(OutputContent{form_factors, balanced}, file);
}

std::vector<std::filesystem::path> filesOf(const std::filesystem::path& file, bool with_balance) {
  if (formatOf(file) == Format::foam) return foamFilesOf(file);
  if (!hasBalancedFile(formatOf(file)) || !with_balance) return {file};
  return {file, std::filesystem::path(file).replace_extension(".balanced" + file.extension().string())};
}

void checkOutput(const std::filesystem::path& file, bool with_balance, bool has_scene) {
  if (with_balance && hasBalancedFile(formatOf(file)) && file.stem().extension() == ".balanced")
    throw Error(ErrorCode::bad_usage, fmt::format("{}: --balance takes names that end in .balanced{} itself; use "
                                                  "another one",
                                                  file.string(), file.extension().string()));
  requireContent(file, has_scene);
  for (const std::filesystem::path& written : filesOf(file, with_balance)) checkWritable(written);
}

void checkEnvironmentOutput(const std::filesystem::path& file) {
  const Format format = formatOf(file);
  for (const Format of_rows : {Format::csv, Format::rows, Format::h5, Format::json, Format::vtp})
    if (format == of_rows) return;
  throw Error(ErrorCode::bad_usage,
              fmt::format("{}: its format is of a matrix; the environment alone is written as .csv, .rows.csv, .h5, "
                          ".json or .vtp",
                          file.string()));
}

void checkRows(const std::filesystem::path& file, const Scene& scene, const Ids& ids) {
  const Format format = formatOf(file);
  if (format == Format::foam) checkFoamRows(file, ids);
  if (format == Format::moose) checkMooseRows(file, ids);
  if (!isBuilding(format)) return;
  requireBuilding(file, &scene);
  checkEnergyPlusRows(file, ids);
}

void checkShown(const Scene& scene, const Ids& ids, const std::vector<std::string>& names) {
  for (const std::string& name : names) shownIds(scene, ids, name);
}

}  // namespace viewpeel
