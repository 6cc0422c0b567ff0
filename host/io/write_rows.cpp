// writeRows() writes area, environment, leak, row sum and errors of each row of the file; a matrix alone lacks them.
#include <cmath>

#include <fmt/ostream.h>

#include "io/csv.h"
#include "io/entry_rows.h"
#include "io/guesses.h"
#include "io/writers.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/environment.h>
#include <viewpeel/sparse_rows.h>

namespace viewpeel {
namespace {

// RowFigures summarise the entries of a row.
struct RowFigures {
  double largest_standard_error = 0, guessed = 0;
};

std::vector<RowFigures> figuresOf(const OutputContent& content) {
  std::vector<RowFigures> figures(content.form_factors.ids().count());
  EntryRows(content.form_factors).forEach([&](const RowEntry& entry) {
    RowFigures& row = figures[entry.i];
    row.largest_standard_error = std::max(row.largest_standard_error, entry.form_factor.standard_error);
    if (isGuess(content, entry.i, entry.j)) row.guessed += entry.form_factor.value;
  });
  return figures;
}

}  // namespace

void writeRows(const OutputContent& content, std::ostream& out) {
  const FormFactors& form_factors = content.form_factors;
  const Ids& ids = form_factors.ids();
  const bool has_intervals = form_factors.hasIntervals(), has_guesses = hasGuesses(content);
  const bool is_alone = content.has_environment_alone;
  out << "row,name,area,environment,environment_standard_error";
  if (!is_alone) out << ",leak,leak_standard_error,row_sum,row_sum_standard_error,largest_standard_error";
  if (has_intervals) out << ",environment_lower,environment_upper,leak_lower,leak_upper";
  if (has_guesses) out << ",guessed";
  if (content.dropped) out << ",dropped,dropped_standard_error";
  if (content.parts)
    out << ",environment_up,environment_up_standard_error,environment_down,environment_down_standard_error";
  if (content.parts && !content.parts->up_intervals.empty())
    out << ",environment_up_lower,environment_up_upper,environment_down_lower,environment_down_upper";
  out << '\n';
  const std::vector<RowFigures> figures = figuresOf(content);
  const std::vector<uint32_t> rows = ids.rows();
  const std::vector<std::string> names = rowNames(ids);
  uint32_t id = 0;
  for (uint32_t row = 0; row < ids.rowCount(); ++row) {
    const bool is_empty = id == ids.count() || rows[id] != row;
    fmt::print(out, "{},{},{}", row + 1, quoteName(names[row]), is_empty ? 0 : ids.areas[id]);
    const auto print = [&](const Measured& value) { fmt::print(out, ",{},{}", value.value, value.standard_error); };
    const bool is_shown = !is_empty && ids.isRequested(id);
    print(is_shown ? form_factors.formFactor(id, kEnvironment) : Measured{});
    if (!is_alone) {
      print(is_shown ? form_factors.formFactor(id, kLeak) : Measured{});
      print(is_shown ? form_factors.rowSums()[id] : Measured{});
      fmt::print(out, ",{}", is_shown ? figures[id].largest_standard_error : 0);
    }
    if (has_intervals)
      for (uint32_t j : {kEnvironment, kLeak}) {
        const Interval interval = is_shown ? form_factors.interval(id, j) : Interval{};
        fmt::print(out, ",{},{}", interval.lower, interval.upper);
      }
    if (has_guesses) fmt::print(out, ",{}", is_shown ? figures[id].guessed : 0);
    if (content.dropped) print(is_shown ? content.dropped->sums[id] : Measured{});
    if (content.parts)
      for (const std::vector<Measured>* part : {&content.parts->up, &content.parts->down})
        print(is_shown ? (*part)[id] : Measured{});
    if (content.parts && !content.parts->up_intervals.empty())
      for (const std::vector<Interval>* intervals : {&content.parts->up_intervals, &content.parts->down_intervals}) {
        const Interval interval = is_shown ? (*intervals)[id] : Interval{};
        fmt::print(out, ",{},{}", interval.lower, interval.upper);
      }
    out << '\n';
    if (!is_empty) ++id;
  }
}

}  // namespace viewpeel
