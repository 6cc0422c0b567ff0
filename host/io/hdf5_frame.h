// A .h5 may be written by several processes: one writes the frame, which is everything but the entries of the matrices,
// and each writes the entries of its rows. So no process ever has the whole matrix.
#pragma once
#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include <viewpeel/write.h>

namespace viewpeel {

// Writes the frame of a .h5.
//   In: rows: its form factors have ids, row sums, and entries for environment and leak alone; starts: of each row of
//     the file among all entries between rows, int64_t[rows + 1]
//   Out: the place of each column of entries among the bytes of the file, by name
//   Throws: Error limit where memory is short; a failure to write is the state of `out`.
std::map<std::string, uint64_t> writeHdf5Frame(const OutputContent& rows, const std::vector<int64_t>& starts,
                                               std::ostream& out);

// Writes the entries of a block of rows.
//   In: block: form factors whose requested ids are the block, one after another; starts, places: of the frame; file:
//     the frame. Several processes may write blocks at the same time.
//   Throws: Error output, naming the file and the system's reason.
void writeHdf5Block(const FormFactors& block, const std::vector<int64_t>& starts,
                    const std::map<std::string, uint64_t>& places, const std::string& file);

}  // namespace viewpeel
