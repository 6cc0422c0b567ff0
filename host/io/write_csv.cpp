// writeCsv() writes each nonzero form factor as a line of comma-separated values.
#include <fmt/ostream.h>

#include "io/csv.h"
#include "io/each_entry.h"
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
  const auto& names = form_factors.ids().names;
  const bool has_intervals = form_factors.hasIntervals(), has_guesses = hasGuesses(content);
  out << "from,to,form_factor,standard_error" << (has_intervals ? ",lower,upper" : "");
  if (has_guesses) out << ",is_guess";
  if (content.balanced) out << ',' << content.balanced_column;
  out << '\n';
  // The parts of the environment, up and down, have no balanced form factors, for only closed scenes are balanced.
  const auto printPart = [&](uint32_t i, const char* name, const Measured& f, const std::vector<Interval>& intervals) {
    if (f.value == 0 && f.standard_error == 0) return;
    fmt::print(out, "{},{},{},{}{}{}{}\n", quoteName(names[i]), name, f.value, f.standard_error,
               !has_intervals      ? ""
               : intervals.empty() ? ",,"
                                   : fmt::format(",{},{}", intervals[i].lower, intervals[i].upper),
               has_guesses ? ",0" : "", content.balanced ? "," : "");
  };
  forEachEntry(form_factors, [&](uint32_t i, uint32_t j, const Measured& f) {
    const std::string to = j == kEnvironment ? "environment" : j == kLeak ? "leak" : quoteName(names[j]);
    fmt::print(out, "{},{},{},{}", quoteName(names[i]), to, f.value, f.standard_error);
    if (has_intervals) {
      const Interval interval = form_factors.interval(i, j);
      fmt::print(out, ",{},{}", interval.lower, interval.upper);
    }
    if (has_guesses) out << (isGuess(content, i, j) ? ",1" : ",0");
    if (content.balanced) fmt::print(out, ",{}", content.balanced->formFactor(i, j).value);
    out << '\n';
    if (j != kEnvironment || !content.parts) return;
    printPart(i, "environment:up", content.parts->up[i], content.parts->up_intervals);
    printPart(i, "environment:down", content.parts->down[i], content.parts->down_intervals);
  });
}

}  // namespace viewpeel
