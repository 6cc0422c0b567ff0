// A checkpoint stores the sums of a run as columns, in a group for each kind of sum.
#pragma once
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "io/hdf5_input.h"
#include "io/hdf5_output.h"
#include "sums/run_sums.h"

namespace viewpeel {

// Writes a column with a value for each row.
//   In: rows: kept by reference until the output is finished, and so is what `value` refers to
template <class T, class Rows, class Value>
void writeColumn(Hdf5Output& out, const std::string& name, const Rows& rows, Value value) {
  if constexpr (std::is_arithmetic_v<T>) {
    out.writeLater<T>(name, rows.size(), [&rows, value](ByteSink& sink) {
      for (const auto& row : rows) sink.put(static_cast<T>(value(row)));
    });
  } else {
    std::vector<T> column;
    for (const auto& row : rows) column.push_back(value(row));
    out.write(name, column);
  }
}

// Reads a column with a value for each row and calls set(row, value).
template <class T, class Rows, class Set>
void readColumn(Hdf5Input& in, const std::string& name, Rows& rows, Set set) {
  const std::vector<T> column = in.read<T>(name, rows.size());
  for (size_t k = 0; k < column.size(); ++k) set(rows[k], column[k]);
}

template <class T>
T readOne(Hdf5Input& in, const std::string& name) {
  return in.read<T>(name, 1).front();
}

// Writes sums, and the ids that they are of, into a group.
void writeReplicateSums(Hdf5Output& out, const std::string& group, const ReplicateSums& sums);
// Writes the prior and its sums, if the run has them.
void writePriorSums(Hdf5Output& out, const RunSums& sums);
// Writes pair lines and their sums, if the run has them.
void writeLineSums(Hdf5Output& out, const RunSums& sums);

// These functions read the sums back.
//   Throws: Error bad_input where columns are missing, have other lengths, or cannot be the sums of a run.
ReplicateSums readReplicateSums(Hdf5Input& in, const std::string& group);
std::optional<PriorSums> readPriorSums(Hdf5Input& in, const Ids& face_ids, const Ids& surface_ids);
std::optional<LineSums> readLineSums(Hdf5Input& in, const Ids& face_ids);

}  // namespace viewpeel
