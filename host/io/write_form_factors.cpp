#include "io/write_form_factors.h"

#include <fmt/ostream.h>

#include "error.h"
#include "io/write_file.h"

namespace viewpeel {
namespace {

using Writer = void (*)(const FormFactors&, std::ostream&);

Writer findWriter(const std::filesystem::path& file) {
  if (file.extension() == ".csv") return writeCsv;
  if (file.extension() == ".mtx") return writeMatrixMarket;
  throw Error(ErrorCode::bad_usage, fmt::format("{}: unknown output format; use a name that ends in .csv or .mtx", file.string()));
}

std::string quoteName(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (char c : name) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

// Calls use(i, j, F_ij) for every nonzero entry of the rows asked for, both ways, row by row.
template <class Use>
void forEachEntry(const FormFactors& form_factors, Use use) {
  std::vector<std::vector<FormFactors::Entry>> rows(form_factors.ids().count());
  for (const FormFactors::Entry& entry : form_factors.entries())
    if (entry.j < kEnvironment && entry.j != entry.i) rows[entry.j].push_back({entry.j, entry.i, entry.exchange_area});
  for (const FormFactors::Entry& entry : form_factors.entries()) rows[entry.i].push_back(entry);
  for (const auto& row : rows)
    for (const FormFactors::Entry& entry : row)
      if (form_factors.ids().isAsked(entry.i)) use(entry.i, entry.j, form_factors.formFactor(entry.i, entry.j));
}

}  // namespace

void writeCsv(const FormFactors& form_factors, std::ostream& out) {
  const auto& names = form_factors.ids().names;
  out << "from,to,form_factor,standard_error\n";
  forEachEntry(form_factors, [&](uint32_t i, uint32_t j, const Measured& f) {
    const std::string to = j == kEnvironment ? "environment" : j == kLeak ? "leak" : quoteName(names[j]);
    fmt::print(out, "{},{},{},{}\n", quoteName(names[i]), to, f.value, f.standard_error);
  });
}

void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out) {
  const Ids& ids = form_factors.ids();
  uint64_t nonzeros = 0;
  forEachEntry(form_factors, [&](uint32_t, uint32_t j, const Measured&) { nonzeros += j < kEnvironment; });
  out << "%%MatrixMarket matrix coordinate real general\n% form factors; per row: number, area, environment share, name\n";
  for (uint32_t i = 0; i < ids.count(); ++i)
    fmt::print(out, "% {} {} {} {}\n", i + 1, ids.areas[i], form_factors.formFactor(i, kEnvironment).value, ids.names[i]);
  fmt::print(out, "{} {} {}\n", ids.count(), ids.count(), nonzeros);
  forEachEntry(form_factors, [&](uint32_t i, uint32_t j, const Measured& f) {
    if (j < kEnvironment) fmt::print(out, "{} {} {}\n", i + 1, j + 1, f.value);
  });
}

void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file) {
  const Writer write = findWriter(file);
  writeFile(file, [&](std::ostream& out) { write(form_factors, out); });
}

void checkOutput(const std::filesystem::path& file) {
  findWriter(file);
  checkWritable(file);
}

}  // namespace viewpeel
