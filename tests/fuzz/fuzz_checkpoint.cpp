// This target reads a checkpoint whose columns may hold wrong values, with a right check sum.
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include <viewpeel/error.h>
#include "estimator/estimate.h"
#include "column_bytes.h"
#include "input_file.h"
#include "io/checkpoint.h"
#include <viewpeel/write.h>

namespace viewpeel {
namespace {

using fuzz::writeColumn;

// Writes sums of two replicates for two ids, one pair and the environment. The group by_id has no pair and no
// environment, for with priors by polygon other sums hold them.
void writeSums(Hdf5Output& out, fuzz::Bytes& bytes, const std::string& group) {
  using U8 = std::vector<uint8_t>;
  using U32 = std::vector<uint32_t>;
  using U64 = std::vector<uint64_t>;
  writeColumn(out, bytes, group + "/names", std::vector<std::string>{"floor", "wall"});
  writeColumn(out, bytes, group + "/areas", std::vector<double>{1, 2});
  writeColumn(out, bytes, group + "/surfaces", U32{0, 1});
  writeColumn(out, bytes, group + "/requested", U8{});
  writeColumn(out, bytes, group + "/splits_surfaces", U8{0});
  writeColumn(out, bytes, group + "/rows_sum_to_one", U8{1});
  writeColumn(out, bytes, group + "/two_sided", U8{0});
  writeColumn(out, bytes, group + "/replicate_count", U64{2});
  const auto writeOf = [&]<class T>(const std::string& name, bool is_there, std::vector<T> whole) {
    writeColumn(out, bytes, group + "/" + name, is_there ? whole : std::vector<T>{});
  };
  const bool has_pairs = group != "by_id";
  for (const std::string part : {"rows", "pairs"}) {
    const bool is_there = part == "rows" || has_pairs;
    if (part == "pairs") {
      writeOf("pairs/i", has_pairs, U32{0, 1});
      writeOf("pairs/j", has_pairs, U32{1, kEnvironment});
    }
    writeOf(part + "/sum_high", is_there, U64{0, 0});
    writeOf(part + "/sum_low", is_there, U64{20, 20});
    writeOf(part + "/sum_of_squares_high", is_there, U64{0, 0});
    writeOf(part + "/sum_of_squares_low", is_there, U64{202, 202});
  }
}

// Adds pair lines between the two ids, and between the first id and a back.
void writeLineSums(Hdf5Output& out, fuzz::Bytes& bytes) {
  using U8 = std::vector<uint8_t>;
  using U32 = std::vector<uint32_t>;
  using U64 = std::vector<uint64_t>;
  writeColumn(out, bytes, "lines/by_surface", U8{0});
  writeColumn(out, bytes, "lines/replicate_count", U64{2});
  writeColumn(out, bytes, "lines/least_form_factor", std::vector<double>{0});  // mixtures have no backs
  writeColumn(out, bytes, "lines/leaking", U8{1, 0});
  writeColumn(out, bytes, "lines/leak_rays", U32{512});
  writeColumn(out, bytes, "lines/i", U32{0, 0});
  writeColumn(out, bytes, "lines/j", U32{1, 3});
  writeColumn(out, bytes, "lines/exchange", std::vector<double>{0.5, 0.2});
  writeColumn(out, bytes, "lines/clear", std::vector<double>{0.1, 0});
  writeColumn(out, bytes, "lines/blocks", U32{2, 1});
  writeColumn(out, bytes, "lines/period", U32{1, 2});
  writeColumn(out, bytes, "lines/by_angles", U8{0, 1});
  writeColumn(out, bytes, "lines/cuts", U32{5, 0});
  writeColumn(out, bytes, "lines/parts", U32{4, 1});
  for (const char* sum : {"facing", "all", "effective", "facing_squares", "products", "all_squares", "drawn_blocks"})
    writeColumn(out, bytes, std::string("lines/") + sum, U64{7, 7});
  writeColumn(out, bytes, "lines/replicates", U32{2, 1});
}

// Adds the pair's unoccluded form factor, lines that end in the environment, and the pair's directions as a directed
// pair.
void writePriorSums(Hdf5Output& out, fuzz::Bytes& bytes) {
  using U8 = std::vector<uint8_t>;
  using U32 = std::vector<uint32_t>;
  using U64 = std::vector<uint64_t>;
  writeColumn(out, bytes, "prior/is_there", U8{1});
  writeColumn(out, bytes, "prior/by_surface", U8{0});
  writeColumn(out, bytes, "prior/has_all_pairs", U8{1});
  writeColumn(out, bytes, "prior/lines", U64{1, 1});
  writeColumn(out, bytes, "prior/ranks", U32{1, 0});
  writeColumn(out, bytes, "prior/pairs/i", U32{0, 1});
  writeColumn(out, bytes, "prior/pairs/j", U32{1, kEnvironment});
  writeColumn(out, bytes, "prior/pairs/visibility", U32{3000, 4096});
  writeColumn(out, bytes, "prior/pairs/surface_visibility", U32{3000, 4096});
  writeColumn(out, bytes, "prior/pairs/exchange", std::vector<double>{0.5, 2});
  writeColumn(out, bytes, "prior/pairs/directed/i", U32{0});
  writeColumn(out, bytes, "prior/pairs/directed/j", U32{1});
  writeColumn(out, bytes, "prior/pairs/directed/directions", U32{16});
  writeColumn(out, bytes, "prior/pairs/directed/resolution", U32{64});
  writeColumn(out, bytes, "prior/pairs/directed/visibility", U32{3000});
  writeColumn(out, bytes, "prior/pairs/directed/line", U32{1});
  writeColumn(out, bytes, "prior/pairs/directed/measure_area", std::vector<double>{0.01});
  writeColumn(out, bytes, "prior/pairs/directed/count_area", std::vector<double>{0.1});
  for (const std::string group : {"prior/faces", "prior/surfaces", "prior/directed"}) {
    const bool of_faces = group == "prior/faces";
    writeColumn(out, bytes, group + "/replicate_count", U64{2});
    writeColumn(out, bytes, group + "/i", U32{0, 1});
    writeColumn(out, bytes, group + "/j", U32{1, kEnvironment});
    if (of_faces) {
      writeColumn(out, bytes, group + "/facing", U64{200, 300});
      writeColumn(out, bytes, group + "/blocked", U64{100, 50});
    } else {
      writeColumn(out, bytes, group + "/line", U64{1, 1});
    }
    for (const std::string& sum : of_faces ? std::vector<std::string>{"facing_squared", "product", "blocked_squared"}
                                           : std::vector<std::string>{"sum", "sum_of_squares", "squares"}) {
      writeColumn(out, bytes, group + "/" + sum + "_high", U64{0, 0});
      writeColumn(out, bytes, group + "/" + sum + "_low", U64{40000, 40000});
    }
  }
}

Checkpoint readBytes(const uint8_t* data, size_t count) {
  static const fuzz::NamedFile file("checkpoint");
  fuzz::Bytes bytes(data, count);
  Hdf5Output out;
  writeColumn(out, bytes, "format", std::vector<uint64_t>{10});
  writeColumn(out, bytes, "settings/names", std::vector<std::string>{"--seed"});
  writeColumn(out, bytes, "settings/values", std::vector<std::string>{"1"});
  writeColumn(out, bytes, "replicates/first", std::vector<uint64_t>{0});
  writeColumn(out, bytes, "replicates/end", std::vector<uint64_t>{2});
  writeColumn(out, bytes, "directions", std::vector<uint64_t>{20});
  writeColumn(out, bytes, "measure_area", std::vector<double>{0.1});
  writeSums(out, bytes, "by_id");
  writeSums(out, bytes, "by_surface");
  writePriorSums(out, bytes);
  if (bytes.take<uint8_t>() % 2) writeLineSums(out, bytes);  // results then come from pair lines
  return readCheckpoint(file.write(out.finish()));
}

// Uses a checkpoint as the program does: reports it, merges it, and continues from it.
void use(Checkpoint checkpoint) {
  requireSameSettings(checkpoint.settings, checkpoint.settings, "again");
  describeReplicates(checkpoint.sums.replicates);
  if (checkpoint.sums.replicateCount() >= 2) {
    const Estimate estimate = makeEstimate(checkpoint.sums, 0.01);
    std::ostringstream text;
    writeCsv(estimate.form_factors, text);
    writeMatrixMarket(estimate.form_factors, text);
  }
  const RunSums others = checkpoint.sums;
  if (others.prior_sums && !(checkpoint.sums.prior_sums->goesWith(*others.prior_sums) &&
                             checkpoint.sums.prior_sums->directsAs(*others.prior_sums)))
    std::abort();
  checkpoint.sums.add(others);
  if (checkpoint.sums.by_id.ids().count() < 2) return;
  PairCounts directed;
  if (checkpoint.sums.prior_sums)
    for (const DirectedPair& pair : checkpoint.sums.prior_sums->prior().directed)
      directed.push_back({pair.i, pair.j, 7, 4});
  const uint64_t next = checkpoint.sums.replicates.empty() ? 0 : checkpoint.sums.replicates.back().end;
  checkpoint.sums.add(next, {{0, 1, 5, 3}, {0, kEnvironment, 2, 0}}, 10, directed);
  checkpoint.sums.betweenSurfaces();
}

}  // namespace
}  // namespace viewpeel

// Empty input must give a valid checkpoint with priors. Otherwise all inputs would be refused, and the target would
// test nothing.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  try {
    if (viewpeel::readBytes(nullptr, 0).sums.prior_sums) return 0;
  } catch (const viewpeel::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  std::abort();
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t count) {
  using namespace viewpeel;
  try {
    use(readBytes(data, count));
  } catch (const Error& error) {
    fuzz::requireOneLine(error.what());
  }
  return 0;
}
