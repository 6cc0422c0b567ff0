// writeCsv() writes each nonzero form factor as a line of comma-separated values.
#include <fmt/compile.h>

#include "io/csv.h"
#include "io/entry_rows.h"
#include "io/guesses.h"
#include "io/writers.h"
#include <viewpeel/environment.h>

namespace viewpeel {

void writeCsv(const FormFactors& form_factors, std::ostream& out, const FormFactors* balanced,
              const char* balanced_column) {
  writeCsv({.form_factors = form_factors, .balanced = balanced, .balanced_column = balanced_column}, out);
}

void writeCsv(const OutputContent& content, std::ostream& out) {
  const FormFactors& form_factors = content.form_factors;
  const bool has_intervals = form_factors.hasIntervals(), has_guesses = hasGuesses(content);
  out << "from,to,form_factor,standard_error" << (has_intervals ? ",lower,upper" : "");
  if (has_guesses) out << ",is_guess";
  if (content.balanced) out << ',' << content.balanced_column;
  out << '\n';
  std::vector<std::string> names;
  for (const std::string& name : form_factors.ids().names) names.push_back(quoteName(name));
  const auto add = [](fmt::memory_buffer& text, const auto& format, const auto&... values) {
    fmt::format_to(fmt::appender(text), format, values...);
  };
  // The parts of the environment, up and down, have no balanced form factors, for only closed scenes are balanced.
  const auto printPart = [&](fmt::memory_buffer& text, uint32_t i, const char* name, const Measured& f,
                             const std::vector<Interval>& intervals) {
    if (f.value == 0 && f.standard_error == 0) return;
    add(text, FMT_COMPILE("{},{},{},{}"), names[i], name, f.value, f.standard_error);
    if (!intervals.empty()) add(text, FMT_COMPILE(",{},{}"), intervals[i].lower, intervals[i].upper);
    else if (has_intervals) add(text, FMT_COMPILE(",,"));
    add(text, FMT_COMPILE("{}{}\n"), has_guesses ? ",0" : "", content.balanced ? "," : "");
  };
  const EntryRows rows(form_factors);
  printEntries(rows, out, [&](const RowEntry& entry, fmt::memory_buffer& text) {
    const auto& [i, j, f, pair] = entry;
    const std::string_view to = j == kEnvironment ? "environment" : j == kLeak ? "leak" : std::string_view(names[j]);
    add(text, FMT_COMPILE("{},{},{},{}"), names[i], to, f.value, f.standard_error);
    if (has_intervals) {
      const Interval interval = rows.intervalOf(entry);
      add(text, FMT_COMPILE(",{},{}"), interval.lower, interval.upper);
    }
    if (has_guesses) add(text, FMT_COMPILE(",{}"), isGuess(content, i, j) ? 1 : 0);
    if (content.balanced) add(text, FMT_COMPILE(",{}"), content.balanced->formFactor(i, j).value);
    add(text, FMT_COMPILE("\n"));
    if (j != kEnvironment || !content.parts) return;
    printPart(text, i, "environment:up", content.parts->up[i], content.parts->up_intervals);
    printPart(text, i, "environment:down", content.parts->down[i], content.parts->down_intervals);
  });
}

}  // namespace viewpeel
