// MixtureEntries goes through the entries of a mixture between polygons: a run in which pairs of large form factors
// have lines, and common directions count the others.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/add_pairs.h"
#include "sums/line_sums.h"
#include "sums/pair_blocks.h"
#include "sums/replicate_sums.h"
#include "threads.h"

namespace viewpeel {

class MixtureEntries {
 public:
  //   In: lines, counted: kept by reference, no pair is in both; no pair with lines has a back. measure_area,
  //     count_area: as in ReplicateSums
  MixtureEntries(const LineSums& lines, const ReplicateSums& counted, double measure_area, double count_area)
      : lines_(lines),
        counted_(counted),
        measure_area_(measure_area),
        count_area_(count_area),
        ray_efficiency_(counted.rayEfficiency(measure_area, count_area)) {}

  size_t count() const { return lines_.pairs().size() + counted_.pairs().size(); }
  // Slices are the entries of ranges of rows: RowRanges.
  size_t sliceCount() const { return counted_.pairs().ranges().count(); }

  // Calls of_lines(slice, place, k) for pair k of lines.pairs(), and of_counted(slice, place, entry) for each counted
  // entry. `place` is the entry's index among all entries in order. Threads share the slices; one slice goes in order.
  template <class OfLines, class OfCounted>
  void forEach(const OfLines& of_lines, const OfCounted& of_counted) const {
    const std::vector<size_t> counted_before = counted_.pairs().firsts();
    shareOut(threadsFor(count()), sliceCount(), 1, [&](size_t, size_t slice) {
      const std::span<const LinePair> with_lines = counted_.pairs().ranges().of(lines_.pairs(), slice);
      const auto first = static_cast<size_t>(with_lines.data() - lines_.pairs().data());
      const auto& counted = counted_.pairs().block(slice);
      for (size_t line = 0, pair = 0; line < with_lines.size() || pair < counted.size();) {
        const size_t place = first + line + counted_before[slice] + pair;
        if (pair == counted.size() || (line < with_lines.size() && keyOf(with_lines[line]) < keyOf(counted[pair])))
          of_lines(slice, place, first + line++);
        else of_counted(slice, place, countedEntry(counted[pair++]));
      }
    });
  }

 private:
  FormFactors::Entry countedEntry(const ReplicateSums::PairSum& pair) const;

  const LineSums& lines_;
  const ReplicateSums& counted_;
  double measure_area_, count_area_, ray_efficiency_;
};

}  // namespace viewpeel
