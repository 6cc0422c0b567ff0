// writeJson() writes a result as one JSON object: rows, and a line for each nonzero form factor between them.
#include <cmath>

#include <fmt/ostream.h>
#include <nlohmann/json.hpp>

#include "io/entry_rows.h"
#include "io/guesses.h"
#include "io/writers.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/environment.h>
#include <viewpeel/sparse_rows.h>

namespace viewpeel {
namespace {

// JSON has no infinity, so an infinite value is null.
std::string numberOf(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

// Returns a text in quotes. Each byte that is not UTF-8 becomes U+FFFD.
std::string quoteText(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void writeRowObjects(const OutputContent& content, std::ostream& out) {
  const FormFactors& form_factors = content.form_factors;
  const Ids& ids = form_factors.ids();
  const std::vector<uint32_t> rows = ids.rows();
  const std::vector<std::string> names = rowNames(ids);
  out << "  \"row_order\": \"faces of the scene file, or with by surface its surfaces\",\n  \"rows\": [";
  uint32_t id = 0;
  for (uint32_t row = 0; row < ids.rowCount(); ++row) {
    fmt::print(out, "{}\n    {{\"name\": {}", row ? "," : "", quoteText(names[row]));
    if (id == ids.count() || rows[id] != row) {
      out << ", \"area\": 0, \"is_empty\": true}";
      continue;
    }
    fmt::print(out, ", \"area\": {}", numberOf(ids.areas[id]));
    for (const auto& [name, j] : {std::pair("environment", kEnvironment), std::pair("leak", kLeak)}) {
      if (!ids.isRequested(id) || !ids.counts_environment) break;
      if (j == kLeak && content.has_environment_alone) break;
      const Measured f = form_factors.formFactor(id, j);
      fmt::print(out, ", \"{}\": {}, \"{}_standard_error\": {}", name, numberOf(f.value), name,
                 numberOf(f.standard_error));
      if (!form_factors.hasIntervals()) continue;
      const Interval interval = form_factors.interval(id, j);
      fmt::print(out, ", \"{}_lower\": {}, \"{}_upper\": {}", name, interval.lower, name, interval.upper);
    }
    if (ids.isRequested(id) && ids.rows_sum_to_one)
      fmt::print(out, ", \"row_sum\": {}, \"row_sum_standard_error\": {}", numberOf(form_factors.rowSums()[id].value),
                 numberOf(form_factors.rowSums()[id].standard_error));
    if (content.dropped && ids.isRequested(id))
      fmt::print(out, ", \"dropped\": {}, \"dropped_standard_error\": {}", numberOf(content.dropped->sums[id].value),
                 numberOf(content.dropped->sums[id].standard_error));
    if (content.parts && ids.isRequested(id))
      for (const auto& [name, part] :
           {std::pair("up", content.parts->up[id]), std::pair("down", content.parts->down[id])})
        fmt::print(out, ", \"environment_{0}\": {1}, \"environment_{0}_standard_error\": {2}", name,
                   numberOf(part.value), numberOf(part.standard_error));
    if (content.parts && ids.isRequested(id) && !content.parts->up_intervals.empty())
      for (const auto& [name, interval] :
           {std::pair("up", content.parts->up_intervals[id]), std::pair("down", content.parts->down_intervals[id])})
        fmt::print(out, ", \"environment_{0}_lower\": {1}, \"environment_{0}_upper\": {2}", name, interval.lower,
                   interval.upper);
    if (!ids.isRequested(id)) out << ", \"is_requested\": false";
    out << "}";
    ++id;
  }
  out << "\n  ]";
}

}  // namespace

void writeJsonMembers(const OutputContent& content, std::ostream& out) {
  const FormFactors &form_factors = content.form_factors, *balanced = content.balanced;
  writeRowObjects(content, out);
  if (content.has_environment_alone) return;
  const bool has_intervals = form_factors.hasIntervals(), has_guesses = hasGuesses(content);
  fmt::print(out,
             ",\n  \"form_factors\": {{\n    \"columns\": [\"from\", \"to\", \"form_factor\", "
             "\"standard_error\"{}{}{}],\n    \"entries\": [",
             has_intervals ? ", \"lower\", \"upper\"" : "", has_guesses ? ", \"is_guess\"" : "",
             balanced ? ", \"balanced_form_factor\"" : "");
  const std::vector<uint32_t> rows = form_factors.ids().rows();
  const char* separator = "\n";
  const EntryRows entries(form_factors);
  entries.forEach([&](const RowEntry& entry) {
    const auto& [i, j, f, pair] = entry;
    if (j >= kEnvironment) return;
    fmt::print(out, "{}      [{}, {}, {}, {}", separator, rows[i], rows[j], numberOf(f.value),
               numberOf(f.standard_error));
    if (has_intervals) {
      const Interval interval = entries.intervalOf(entry);
      fmt::print(out, ", {}, {}", interval.lower, interval.upper);
    }
    if (has_guesses) out << (isGuess(content, i, j) ? ", true" : ", false");
    if (balanced) fmt::print(out, ", {}", balanced->formFactor(i, j).value);
    out << "]";
    separator = ",\n";
  });
  out << "\n    ]\n  }";
}

void writeJson(const OutputContent& content, std::ostream& out) {
  out << "{\n";
  for (const auto& [name, value] : content.parameters)
    fmt::print(out, "  {}: {},\n", quoteText(name), quoteText(value));
  if (content.scene) fmt::print(out, "  \"scene_file\": {},\n", quoteText(content.scene->file));
  writeJsonMembers(content, out);
  out << "\n}\n";
}

}  // namespace viewpeel
