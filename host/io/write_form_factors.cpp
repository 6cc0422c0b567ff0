#include <viewpeel/write.h>

#include <fmt/ostream.h>

#include <viewpeel/error.h>
#include "io/csv.h"
#include "io/write_file.h"

namespace viewpeel {
namespace {

bool isMatrixMarket(const std::filesystem::path& file) {
  if (file.extension() == ".csv") return false;
  if (file.extension() == ".mtx") return true;
  throw Error(ErrorCode::bad_usage,
              fmt::format("{}: unknown output format; use a name that ends in .csv or .mtx", file.string()));
}

// Calls use(i, j, F_ij) for every nonzero entry of the requested rows, both ways, row by row.
template <class Use>
void forEachEntry(const FormFactors& form_factors, Use use) {
  std::vector<std::vector<FormFactors::Entry>> rows(form_factors.ids().count());
  for (const FormFactors::Entry& entry : form_factors.entries())
    if (entry.j < kEnvironment && entry.j != entry.i) rows[entry.j].push_back({entry.j, entry.i, entry.exchange_area});
  for (const FormFactors::Entry& entry : form_factors.entries()) rows[entry.i].push_back(entry);
  for (const auto& row : rows)
    for (const FormFactors::Entry& entry : row)
      if (form_factors.ids().isRequested(entry.i)) use(entry.i, entry.j, form_factors.formFactor(entry.i, entry.j));
}

}  // namespace

void writeCsv(const FormFactors& form_factors, std::ostream& out, const FormFactors* balanced) {
  const auto& names = form_factors.ids().names;
  const bool has_intervals = form_factors.hasIntervals();
  out << "from,to,form_factor,standard_error" << (has_intervals ? ",lower,upper" : "")
      << (balanced ? ",balanced_form_factor\n" : "\n");
  forEachEntry(form_factors, [&](uint32_t i, uint32_t j, const Measured& f) {
    const std::string to = j == kEnvironment ? "environment" : j == kLeak ? "leak" : quoteName(names[j]);
    fmt::print(out, "{},{},{},{}", quoteName(names[i]), to, f.value, f.standard_error);
    if (has_intervals) {
      const Interval interval = form_factors.interval(i, j);
      fmt::print(out, ",{},{}", interval.lower, interval.upper);
    }
    if (balanced) fmt::print(out, ",{}", balanced->formFactor(i, j).value);
    out << '\n';
  });
}

void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out, const char* what) {
  const Ids& ids = form_factors.ids();
  uint64_t nonzeros = 0;
  forEachEntry(form_factors, [&](uint32_t, uint32_t j, const Measured&) { nonzeros += j < kEnvironment; });
  fmt::print(out,
             "%%MatrixMarket matrix coordinate real general\n% {}; per row: number, area, environment share, name\n",
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
  forEachEntry(form_factors, [&](uint32_t i, uint32_t j, const Measured& f) {
    if (j < kEnvironment) fmt::print(out, "{} {} {}\n", rows[i] + 1, rows[j] + 1, f.value);
  });
}

void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file, const FormFactors* balanced) {
  if (!isMatrixMarket(file)) {
    writeFile(file, [&](std::ostream& out) { writeCsv(form_factors, out, balanced); });
    return;
  }
  writeFile(file, [&](std::ostream& out) { writeMatrixMarket(form_factors, out); });
  if (balanced)
    writeFile(filesOf(file, true)[1],
              [&](std::ostream& out) { writeMatrixMarket(*balanced, out, "balanced form factors"); });
}

std::vector<std::filesystem::path> filesOf(const std::filesystem::path& file, bool with_balance) {
  if (!with_balance || !isMatrixMarket(file)) return {file};
  return {file, std::filesystem::path(file).replace_extension(".balanced.mtx")};
}

void checkOutput(const std::filesystem::path& file, bool with_balance) {
  if (with_balance && isMatrixMarket(file) && file.stem().extension() == ".balanced")
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("{}: --balance takes names that end in .balanced.mtx itself; use another one", file.string()));
  isMatrixMarket(file);
  for (const std::filesystem::path& written : filesOf(file, with_balance)) checkWritable(written);
}

}  // namespace viewpeel
