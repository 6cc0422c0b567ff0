// writeVwf() writes CalculiX's view factors, .vwf: unformatted Fortran records, which *VIEWFACTOR,READ reads.
//   Sources: CalculiX 2.20, readview.f and writeview.f; GNU Fortran, File format of unformatted sequential files.
#include <algorithm>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include <viewpeel/sparse_rows.h>
#include "io/put_bytes.h"
#include "io/writers.h"
#include "scene/ccx_deck.h"

namespace viewpeel {
namespace {

constexpr uint64_t kLongestPiece = 2147483639;  // longest piece of a record in gfortran's files
constexpr size_t kVersionBytes = 80;

// A FortranRecord has a known length. It is written in pieces, each between two copies of the piece's length. The first
// copy is negative if another piece follows, and the second copy if another piece precedes.
class FortranRecord {
 public:
  FortranRecord(std::ostream& out, uint64_t bytes) : out_(out), left_(bytes) { begin(); }
  ~FortranRecord() { end(); }
  FortranRecord(const FortranRecord&) = delete;
  void add(const char* bytes, uint64_t count) {
    while (count > 0) {
      if (piece_left_ == 0) {
        end();
        is_first_ = false;
        begin();
      }
      const uint64_t part = std::min(count, piece_left_);
      out_.write(bytes, static_cast<std::streamsize>(part));
      bytes += part;
      count -= part;
      piece_left_ -= part;
    }
  }
  void add(double value) { add(reinterpret_cast<const char*>(&value), sizeof value); }

 private:
  void mark(int32_t value) { putBytes(out_, value); }
  void begin() {
    piece_ = piece_left_ = std::min(left_, kLongestPiece);
    left_ -= piece_;
    mark(static_cast<int32_t>(left_ > 0 ? -int64_t(piece_) : int64_t(piece_)));
  }
  void end() { mark(static_cast<int32_t>(is_first_ ? int64_t(piece_) : -int64_t(piece_))); }

  std::ostream& out_;
  uint64_t left_, piece_ = 0, piece_left_ = 0;
  bool is_first_ = true;
};

// Rows have the cavities of a CalculiX deck, and whether each is closed. In other scenes all rows share one open
// cavity.
struct Rows {
  std::vector<int> cavities;
  std::vector<bool> is_closed;
};

Rows rowsOf(const OutputContent& content, size_t count) {
  Rows rows{std::vector<int>(count, 0), std::vector<bool>(count, false)};
  if (!content.scene || !content.scene->file.ends_with(".inp")) return rows;  // the reader is chosen so, too
  const CcxDeck deck = readCcxDeck(content.scene->file);
  if (deck.faces.size() != count)
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: the deck has {} radiating faces now, and {} were computed; leave "
                            "the deck as it is until the .vwf is written",
                            deck.file, deck.faces.size(), count));
  for (size_t k = 0; k < count; ++k) {
    rows.cavities[k] = deck.faces[k].cavity;
    rows.is_closed[k] = deck.faces[k].is_closed;
  }
  return rows;
}

// Writes pairs of one cavity below the diagonal, column by column: first all F(row -> column), then F(column -> row).
void writePairs(const SparseRows& sparse, const SparseRows& transposed, const std::vector<int>& cavities,
                FortranRecord& record) {
  const auto n = static_cast<int64_t>(cavities.size());
  for (const SparseRows* of : {&transposed, &sparse}) {
    std::vector<double> column(cavities.size());
    for (int64_t c = 0; c < n; ++c) {
      std::fill(column.begin(), column.end(), 0.0);
      for (int64_t k = of->starts[c]; k < of->starts[c + 1]; ++k) column[of->columns[k]] = of->form_factors[k];
      for (int64_t r = c + 1; r < n; ++r)
        if (cavities[r] == cavities[c]) record.add(column[r]);
    }
  }
}

SparseRows transpose(const SparseRows& sparse) {
  SparseRows out;
  out.starts.assign(sparse.starts.size(), 0);
  for (int32_t column : sparse.columns) ++out.starts[column + 1];
  for (size_t k = 1; k < out.starts.size(); ++k) out.starts[k] += out.starts[k - 1];
  out.columns.resize(sparse.columns.size());
  out.form_factors.resize(sparse.columns.size());
  std::vector<int64_t> next(out.starts.begin(), out.starts.end() - 1);
  for (int64_t i = 0; i < sparse.rowCount(); ++i)
    for (int64_t k = sparse.starts[i]; k < sparse.starts[i + 1]; ++k) {
      const int64_t at = next[sparse.columns[k]]++;
      out.columns[at] = static_cast<int32_t>(i);
      out.form_factors[at] = sparse.form_factors[k];
    }
  return out;
}

}  // namespace

void writeVwf(const OutputContent& content, std::ostream& out) {
  const SparseRows sparse = compressRows(content.balanced ? *content.balanced : content.form_factors);
  const auto n = static_cast<uint64_t>(sparse.rowCount());
  const Rows rows = rowsOf(content, n);
  std::vector<double> diagonal(n, 0.0), sums(n, 0.0);
  for (uint64_t i = 0; i < n; ++i)
    for (int64_t k = sparse.starts[i]; k < sparse.starts[i + 1]; ++k) {
      const auto j = static_cast<uint64_t>(sparse.columns[k]);
      if (j == i) diagonal[i] = sparse.form_factors[k];
      if (rows.cavities[i] == rows.cavities[j]) sums[i] += sparse.form_factors[k];
    }
  uint64_t pair_count = 0;
  std::vector<int> cavities = rows.cavities;
  std::sort(cavities.begin(), cavities.end());
  for (auto at = cavities.begin(); at != cavities.end();) {
    const auto end = std::upper_bound(at, cavities.end(), *at);
    pair_count += pairCount(static_cast<uint64_t>(end - at));
    at = end;
  }
  if (content.ccx_version != "none") {
    std::string version = "Version " + content.ccx_version;
    version.resize(kVersionBytes, ' ');
    FortranRecord(out, kVersionBytes).add(version.data(), kVersionBytes);
  }
  {
    FortranRecord record(out, n * sizeof(double));
    for (double value : diagonal) record.add(value);
  }
  {
    FortranRecord record(out, 2 * pair_count * sizeof(double));
    writePairs(sparse, transpose(sparse), rows.cavities, record);
  }
  FortranRecord record(out, n * sizeof(double));
  for (uint64_t i = 0; i < n; ++i) record.add(rows.is_closed[i] ? 0.0 : 1 - sums[i]);
}

}  // namespace viewpeel
