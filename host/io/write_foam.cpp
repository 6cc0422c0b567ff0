// writeFoam() writes OpenFOAM's view factors as text: F and globalFaceFaces, with the maps between ranks.
//   Source: OpenFOAM v1912, viewFactorsGen.C and viewFactor.C; OpenFOAM-dev, viewFactor.C; mapDistributeBaseIO.C.
#include <algorithm>

#include <fmt/ostream.h>

#include <viewpeel/error.h>
#include <viewpeel/sparse_rows.h>
#include "io/write_file.h"
#include "io/writers.h"
#include "scene/foam_case.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

void writeHeader(std::ostream& out, const char* kind, const char* object) {
  fmt::print(out,
             "FoamFile\n{{\n    version 2.0;\n    format ascii;\n    class {};\n    location \"constant\";\n"
             "    object {};\n}}\n\n",
             kind, object);
}

// Writes the numbers from `first` to last - 1 as a list.
void writeRange(std::ostream& out, uint64_t first, uint64_t last) {
  fmt::print(out, "{}(", last - first);
  for (uint64_t k = first; k < last; ++k) fmt::print(out, "{}{}", k == first ? "" : " ", k);
  out << ")\n";
}

// Writes which rows a rank sends to others: all, to each. Received rows follow the rank's rows, rank by rank.
void writeSubMap(std::ostream& out, const std::vector<uint64_t>& counts, size_t rank) {
  fmt::print(out, "{}\n(\n", counts.size());
  for (size_t to = 0; to < counts.size(); ++to) writeRange(out, 0, counts[rank]);
  out << ")\n";
}
void writeConstructMap(std::ostream& out, const std::vector<uint64_t>& counts, size_t rank) {
  fmt::print(out, "{}\n(\n", counts.size());
  uint64_t next = counts[rank];
  for (size_t from = 0; from < counts.size(); ++from) {
    const uint64_t first = from == rank ? 0 : next;
    writeRange(out, first, first + counts[from]);
    if (from != rank) next += counts[from];
  }
  out << ")\n";
}

// Writes the maps of both kinds of OpenFOAM: one file for OpenFOAM Ltd.'s versions, three for the Foundation's. From
// 2021 on, OpenFOAM Ltd.'s file has the number of a communicator after the two flips. These versions read the 0 of
// `0()` as this number and the `()` as an empty list; older ones read an empty list of 0 entries.
void writeMaps(const fs::path& folder, const std::vector<uint64_t>& counts, size_t rank) {
  uint64_t total = 0;
  for (uint64_t count : counts) total += count;
  writeFile(folder / "mapDist", [&](std::ostream& out) {
    writeHeader(out, "mapDistribute", "mapDist");
    fmt::print(out, "{}\n", total);
    writeSubMap(out, counts, rank);
    writeConstructMap(out, counts, rank);
    out << "0 0\n\n0()\n0()\n";
  });
  writeFile(folder / "subMap", [&](std::ostream& out) {
    writeHeader(out, "labelListList", "subMap");
    writeSubMap(out, counts, rank);
  });
  writeFile(folder / "constructMap", [&](std::ostream& out) {
    writeHeader(out, "labelListList", "constructMap");
    writeConstructMap(out, counts, rank);
  });
  writeFile(folder / "constructMapDim", [&](std::ostream& out) {
    writeHeader(out, "labelList", "constructMapDim");
    fmt::print(out, "1({})\n", total);
  });
}

// Writes rows `first` to last - 1: the form factors above 0, or their columns.
template <class T>
void writeRows(std::ostream& out, const SparseRows& rows, const std::vector<T>& values, uint64_t first, uint64_t last) {
  fmt::print(out, "{}\n(\n", last - first);
  for (uint64_t row = first; row < last; ++row) {
    fmt::print(out, "{}(", rows.starts[row + 1] - rows.starts[row]);
    for (int64_t k = rows.starts[row]; k < rows.starts[row + 1]; ++k)
      fmt::print(out, "{}{}", k == rows.starts[row] ? "" : " ", values[k]);
    out << ")\n";
  }
  out << ")\n";
}

}  // namespace

std::vector<fs::path> foamFilesOf(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::path& of_rank : findFoamFolders(folder))
    for (const char* name : {"F", "globalFaceFaces", "mapDist", "subMap", "constructMap", "constructMapDim"})
      files.push_back(of_rank / name);
  return files;
}

void checkFoamRows(const fs::path& folder, const Ids& ids) {
  std::vector<std::string> names;
  for (const FoamRank& rank : readFoamCase(folder))
    for (const FoamRank::CoarseFace& face : rank.coarse_faces) names.push_back(face.name);
  const std::vector<std::string> rows = rowNames(ids);
  if (rows == names) return;
  const auto [row, name] = std::mismatch(rows.begin(), rows.end(), names.begin(), names.end());
  throw Error(
      ErrorCode::bad_usage,
      fmt::format("{}: rows are to be its {} coarse faces, and row {} is '{}' in place of '{}'; compute this case "
                  "with --by surface",
                  folder.string(), names.size(), row - rows.begin() + 1, row == rows.end() ? "" : *row,
                  name == names.end() ? "" : *name));
}

void writeFoam(const OutputContent& content, const fs::path& folder) {
  const FormFactors& form_factors = content.balanced ? *content.balanced : content.form_factors;
  checkFoamRows(folder, form_factors.ids());
  const std::vector<FoamRank> ranks = readFoamCase(folder);
  const SparseRows rows = compressRows(form_factors);
  std::vector<uint64_t> counts;
  for (const FoamRank& rank : ranks) counts.push_back(rank.coarse_faces.size());
  uint64_t first = 0;
  for (size_t rank = 0; rank < counts.size(); ++rank) {
    const fs::path& of_rank = ranks[rank].folder;
    const uint64_t last = first + counts[rank];
    writeFile(of_rank / "F", [&](std::ostream& out) {
      writeHeader(out, "scalarListList", "F");
      writeRows(out, rows, rows.form_factors, first, last);
    });
    writeFile(of_rank / "globalFaceFaces", [&](std::ostream& out) {
      writeHeader(out, "labelListList", "globalFaceFaces");
      writeRows(out, rows, rows.columns, first, last);
    });
    writeMaps(of_rank, counts, rank);
    first = last;
  }
}

}  // namespace viewpeel
