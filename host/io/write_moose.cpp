// writeMoose() writes a block of MOOSE's input: SpecifiedViewFactor, whose rows are sidesets.
//   Source: MOOSE, heat transfer module, SpecifiedViewFactor.
#include <fmt/ostream.h>

#include <viewpeel/error.h>
#include <viewpeel/sparse_rows.h>
#include "io/writers.h"

namespace viewpeel {

void checkMooseRows(const std::filesystem::path& file, const Ids& ids) {
  for (const std::string& name : rowNames(ids))
    if (name.empty() || name.find_first_of(" \t\"';#[]") != std::string::npos)
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("{}: MOOSE takes no boundary called '{}'; rename the surface, without blanks and brackets "
                      "(rows are boundaries with --by surface)",
                      file.string(), name));
}

void writeMoose(const FormFactors& form_factors, std::ostream& out) {
  const SparseRows rows = compressRows(form_factors);
  std::string boundary;
  for (const std::string& name : rowNames(form_factors.ids())) boundary += (boundary.empty() ? "" : " ") + name;
  fmt::print(out,
             "# row i of view_factors is from the i-th boundary, column j to the j-th: in the order of the scene file\n"
             "[UserObjects]\n  [view_factors]\n    type = SpecifiedViewFactor\n    boundary = '{}'\n"
             "    view_factors = '",
             boundary);
  std::vector<double> row;
  for (int64_t i = 0; i < rows.rowCount(); ++i) {
    row.assign(static_cast<size_t>(rows.rowCount()), 0.0);
    for (int64_t k = rows.starts[i]; k < rows.starts[i + 1]; ++k) row[rows.columns[k]] = rows.form_factors[k];
    if (i > 0) out << " ;\n                    ";
    for (size_t j = 0; j < row.size(); ++j) fmt::print(out, "{}{}", j ? " " : "", row[j]);
  }
  out << "'\n    normalize_view_factor = false\n    execute_on = INITIAL\n  []\n[]\n";
}

}  // namespace viewpeel
