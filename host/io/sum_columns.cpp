#include "io/sum_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

using Sum = ReplicateSums::Sum;
using PairSum = ReplicateSums::PairSum;
using ControlSum = ControlVariateSums::PairSum;
using VisibilitySum = VisibilitySums::PairSum;
using LineSum = LineSums::PairSum;
using Wide = ReplicateSums::Wide;

constexpr ControlVariateSums::SignedWide kMostControl =
    ControlVariateSums::SignedWide(1)
    << 126;  // the sum of 2^64 replicates of up to 2^62 (takeControlVariates); two such sums add without overflow
constexpr uint64_t kMostLines = uint64_t(1) << 63;  // most facing, or blocked: two such sums add without overflow

uint64_t highOf(Wide number) { return static_cast<uint64_t>(number >> 64); }
uint64_t lowOf(Wide number) { return static_cast<uint64_t>(number); }

template <class Rows, class SumOf>
void writeSums(Hdf5Output& out, const std::string& group, const Rows& rows, SumOf sum_of) {
  writeColumn<uint64_t>(out, group + "/sum_high", rows, [sum_of](const auto& row) { return highOf(sum_of(row).sum); });
  writeColumn<uint64_t>(out, group + "/sum_low", rows, [sum_of](const auto& row) { return lowOf(sum_of(row).sum); });
  writeColumn<uint64_t>(out, group + "/sum_of_squares_high", rows,
                        [sum_of](const auto& row) { return highOf(sum_of(row).sum_of_squares); });
  writeColumn<uint64_t>(out, group + "/sum_of_squares_low", rows,
                        [sum_of](const auto& row) { return lowOf(sum_of(row).sum_of_squares); });
}

template <class Rows, class SumOf>
void readSums(Hdf5Input& in, const std::string& group, Rows& rows, SumOf sum_of) {
  readColumn<uint64_t>(in, group + "/sum_high", rows,
                       [&](auto& row, uint64_t word) { sum_of(row).sum = Wide(word) << 64; });
  readColumn<uint64_t>(in, group + "/sum_low", rows, [&](auto& row, uint64_t word) { sum_of(row).sum |= word; });
  readColumn<uint64_t>(in, group + "/sum_of_squares_high", rows,
                       [&](auto& row, uint64_t word) { sum_of(row).sum_of_squares = Wide(word) << 64; });
  readColumn<uint64_t>(in, group + "/sum_of_squares_low", rows,
                       [&](auto& row, uint64_t word) { sum_of(row).sum_of_squares |= word; });
}

// Writes 128-bit numbers as two columns of 64 bits.
template <class Pairs, class Value>
void writeWide(Hdf5Output& out, const std::string& name, const Pairs& pairs, Value value) {
  writeColumn<uint64_t>(out, name + "_high", pairs, [value](const auto& pair) { return highOf(Wide(value(pair))); });
  writeColumn<uint64_t>(out, name + "_low", pairs, [value](const auto& pair) { return lowOf(Wide(value(pair))); });
}

template <class Pairs, class Set>
void readWide(Hdf5Input& in, const std::string& name, Pairs& pairs, Set set) {
  std::vector<Wide> words(pairs.size());
  readColumn<uint64_t>(in, name + "_high", words, [](Wide& wide, uint64_t word) { wide = Wide(word) << 64; });
  readColumn<uint64_t>(in, name + "_low", words, [](Wide& wide, uint64_t word) { wide |= word; });
  for (size_t k = 0; k < pairs.size(); ++k) set(pairs[k], words[k]);
}

// Writes flags unless there are none, and reads them back.
void writeFlags(Hdf5Output& out, const std::string& name, const std::vector<bool>& flags) {
  if (!flags.empty()) writeColumn<uint8_t>(out, name, flags, [](bool flag) { return flag; });
}
std::vector<bool> readFlags(Hdf5Input& in, const std::string& name, size_t count) {
  if (!in.has(name)) return {};
  const std::vector<uint8_t> flags = in.read<uint8_t>(name, count);
  return {flags.begin(), flags.end()};
}

template <class Pairs>
void requireOrder(Hdf5Input& in, const std::string& group, const Pairs& pairs, uint32_t count) {
  for (size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = keyOf(pairs[k]);
    const bool is_pair = i < count && i <= j && (j < count || j >= kEnvironment);
    if (!is_pair || (k && keyOf(pairs[k - 1]) >= keyOf(pairs[k])))
      in.refuse(fmt::format("its '{}' are out of order", group));
  }
}

ControlVariateSums readControlSums(Hdf5Input& in, const std::string& group, const Ids& ids) {
  const auto replicate_count = readOne<uint64_t>(in, group + "/replicate_count");
  std::vector<ControlSum> pairs;
  for (uint32_t i : in.read<uint32_t>(group + "/i")) pairs.push_back({i, 0});
  readColumn<uint32_t>(in, group + "/j", pairs, [](ControlSum& pair, uint32_t j) { pair.j = j; });
  readColumn<uint64_t>(in, group + "/line", pairs, [](ControlSum& pair, uint64_t line) { pair.line = line; });
  readWide(in, group + "/sum", pairs, [&](ControlSum& pair, Wide wide) {
    pair.sum = static_cast<ControlVariateSums::SignedWide>(wide);
    if (pair.sum >= kMostControl || pair.sum <= -kMostControl)
      in.refuse(fmt::format("its '{}/sum' are larger than sums can be", group));
  });
  readWide(in, group + "/sum_of_squares", pairs, [](ControlSum& pair, Wide wide) { pair.sum_of_squares = wide; });
  readWide(in, group + "/squares", pairs, [](ControlSum& pair, Wide wide) { pair.squares = wide; });
  requireOrder(in, group, pairs, ids.count());
  return {ids, replicate_count, std::move(pairs)};
}

VisibilitySums readVisibilitySums(Hdf5Input& in, const std::string& group, const Ids& ids) {
  const auto replicate_count = readOne<uint64_t>(in, group + "/replicate_count");
  std::vector<VisibilitySum> pairs;
  for (uint32_t i : in.read<uint32_t>(group + "/i")) pairs.push_back({i, 0});
  readColumn<uint32_t>(in, group + "/j", pairs, [](VisibilitySum& pair, uint32_t j) { pair.j = j; });
  readColumn<uint64_t>(in, group + "/facing", pairs,
                       [](VisibilitySum& pair, uint64_t facing) { pair.facing = facing; });
  readColumn<uint64_t>(in, group + "/blocked", pairs,
                       [](VisibilitySum& pair, uint64_t blocked) { pair.blocked = blocked; });
  std::vector<VisibilitySums::Squares> squares(pairs.size());
  readWide(in, group + "/facing_squared", squares,
           [](VisibilitySums::Squares& of_pair, Wide wide) { of_pair.facing = wide; });
  readWide(in, group + "/product", squares,
           [](VisibilitySums::Squares& of_pair, Wide wide) { of_pair.product = wide; });
  readWide(in, group + "/blocked_squared", squares,
           [](VisibilitySums::Squares& of_pair, Wide wide) { of_pair.blocked = wide; });
  for (const VisibilitySum& pair : pairs)
    if (std::max(pair.facing, pair.blocked) >= kMostLines)
      in.refuse(fmt::format("its '{}' are larger than sums can be", group));
  requireOrder(in, group, pairs, ids.count());
  return {ids, replicate_count, std::move(pairs), squares};
}

// Reads empty rows. A file without empty rows lacks these columns.
std::vector<EmptyRow> readEmptyRows(Hdf5Input& in, const std::string& group, uint32_t id_count) {
  std::vector<EmptyRow> empty_rows;
  if (!in.has(group + "/empty_rows")) return empty_rows;
  for (uint32_t row : in.read<uint32_t>(group + "/empty_rows")) empty_rows.push_back({row, {}});
  readColumn<std::string>(in, group + "/empty_names", empty_rows,
                          [](EmptyRow& empty, const std::string& name) { empty.name = name; });
  for (size_t k = 0; k < empty_rows.size(); ++k)
    if (empty_rows[k].row >= id_count + empty_rows.size() || (k > 0 && empty_rows[k].row <= empty_rows[k - 1].row))
      in.refuse(fmt::format("its '{}/empty_rows' are not among its rows", group));
  return empty_rows;
}

}  // namespace

void writeReplicateSums(Hdf5Output& out, const std::string& group, const ReplicateSums& sums) {
  const Ids& ids = sums.ids();
  out.write(group + "/names", ids.names);
  out.write(group + "/areas", ids.areas);
  out.write(group + "/surfaces", ids.surface);
  writeColumn<uint8_t>(out, group + "/requested", ids.requested, [](bool requested) { return requested; });
  writeFlags(out, group + "/only_blocks", ids.only_blocks);
  out.write(group + "/splits_surfaces", std::vector<uint8_t>{ids.splits_surfaces});
  out.write(group + "/rows_sum_to_one", std::vector<uint8_t>{ids.rows_sum_to_one});
  out.write(group + "/two_sided", std::vector<uint8_t>{ids.two_sided});
  if (!ids.empty_rows.empty()) {
    writeColumn<uint32_t>(out, group + "/empty_rows", ids.empty_rows, [](const EmptyRow& empty) { return empty.row; });
    writeColumn<std::string>(out, group + "/empty_names", ids.empty_rows,
                             [](const EmptyRow& empty) { return empty.name; });
  }
  out.write(group + "/replicate_count", std::vector<uint64_t>{sums.replicateCount()});
  if (sums.further().replicates) {
    out.write(group + "/further/replicate_count", std::vector<uint64_t>{sums.further().replicates});
    out.write(group + "/further/of_rows", sums.further().of_rows);
  }
  writeSums(out, group + "/rows", sums.rowSums(), [](const Sum& sum) -> const Sum& { return sum; });
  writeColumn<uint32_t>(out, group + "/pairs/i", sums.pairs(), [](const PairSum& pair) { return pair.i; });
  writeColumn<uint32_t>(out, group + "/pairs/j", sums.pairs(), [](const PairSum& pair) { return pair.j; });
  writeSums(out, group + "/pairs", sums.pairs(), [](const PairSum& pair) -> const Sum& { return pair.sum; });
}

void writePriorSums(Hdf5Output& out, const RunSums& sums) {
  out.write("prior/is_there", std::vector<uint8_t>{sums.prior_sums.has_value()});
  if (!sums.prior_sums) return;
  out.write("prior/by_surface", std::vector<uint8_t>{sums.prior_sums->by() == By::surface});
  const Prior& prior = sums.prior_sums->prior();
  out.write("prior/has_all_pairs", std::vector<uint8_t>{prior.has_all_pairs});
  out.write("prior/lines", prior.lines);
  out.write("prior/ranks", prior.ranks);
  writeColumn<uint32_t>(out, "prior/pairs/i", prior.pairs, [](const PairPrior& pair) { return pair.i; });
  writeColumn<uint32_t>(out, "prior/pairs/j", prior.pairs, [](const PairPrior& pair) { return pair.j; });
  writeColumn<uint32_t>(out, "prior/pairs/visibility", prior.pairs,
                        [](const PairPrior& pair) { return pair.visibility; });
  writeColumn<uint32_t>(out, "prior/pairs/surface_visibility", prior.pairs,
                        [](const PairPrior& pair) { return pair.surface_visibility; });
  writeColumn<double>(out, "prior/pairs/exchange", prior.pairs, [](const PairPrior& pair) { return pair.exchange; });
  writeColumn<uint32_t>(out, "prior/pairs/directed/i", prior.directed, [](const DirectedPair& pair) { return pair.i; });
  writeColumn<uint32_t>(out, "prior/pairs/directed/j", prior.directed, [](const DirectedPair& pair) { return pair.j; });
  writeColumn<uint32_t>(out, "prior/pairs/directed/directions", prior.directed,
                        [](const DirectedPair& pair) { return pair.directions; });
  writeColumn<uint32_t>(out, "prior/pairs/directed/resolution", prior.directed,
                        [](const DirectedPair& pair) { return pair.resolution; });
  writeColumn<uint32_t>(out, "prior/pairs/directed/visibility", prior.directed,
                        [](const DirectedPair& pair) { return pair.visibility; });
  writeColumn<uint32_t>(out, "prior/pairs/directed/line", prior.directed,
                        [](const DirectedPair& pair) { return pair.line; });
  writeColumn<double>(out, "prior/pairs/directed/measure_area", prior.directed,
                      [](const DirectedPair& pair) { return pair.measure_area; });
  writeColumn<double>(out, "prior/pairs/directed/count_area", prior.directed,
                      [](const DirectedPair& pair) { return pair.count_area; });
  const std::vector<VisibilitySum>& faces = sums.prior_sums->byFace().pairs();
  out.write("prior/faces/replicate_count", std::vector<uint64_t>{sums.prior_sums->byFace().replicateCount()});
  writeColumn<uint32_t>(out, "prior/faces/i", faces, [](const VisibilitySum& pair) { return pair.i; });
  writeColumn<uint32_t>(out, "prior/faces/j", faces, [](const VisibilitySum& pair) { return pair.j; });
  writeColumn<uint64_t>(out, "prior/faces/facing", faces, [](const VisibilitySum& pair) { return pair.facing; });
  writeColumn<uint64_t>(out, "prior/faces/blocked", faces, [](const VisibilitySum& pair) { return pair.blocked; });
  writeWide(out, "prior/faces/facing_squared", faces,
            [&sums](const VisibilitySum& pair) { return sums.prior_sums->byFace().squaresOf(pair).facing; });
  writeWide(out, "prior/faces/product", faces,
            [&sums](const VisibilitySum& pair) { return sums.prior_sums->byFace().squaresOf(pair).product; });
  writeWide(out, "prior/faces/blocked_squared", faces,
            [&sums](const VisibilitySum& pair) { return sums.prior_sums->byFace().squaresOf(pair).blocked; });
  for (const auto& [name, controls] : {std::pair(std::string("prior/surfaces"), &sums.prior_sums->surfaceControls()),
                                       {"prior/directed", &sums.prior_sums->directed()}}) {
    out.write(name + "/replicate_count", std::vector<uint64_t>{controls->replicateCount()});
    writeColumn<uint32_t>(out, name + "/i", controls->pairs(), [](const ControlSum& pair) { return pair.i; });
    writeColumn<uint32_t>(out, name + "/j", controls->pairs(), [](const ControlSum& pair) { return pair.j; });
    writeColumn<uint64_t>(out, name + "/line", controls->pairs(), [](const ControlSum& pair) { return pair.line; });
    writeWide(out, name + "/sum", controls->pairs(), [](const ControlSum& pair) { return pair.sum; });
    writeWide(out, name + "/sum_of_squares", controls->pairs(),
              [](const ControlSum& pair) { return pair.sum_of_squares; });
    writeWide(out, name + "/squares", controls->pairs(), [](const ControlSum& pair) { return pair.squares; });
  }
}

void writeLineSums(Hdf5Output& out, const RunSums& sums) {
  if (!sums.lines) return;
  const LineSums& lines = *sums.lines;
  out.write("lines/by_surface", std::vector<uint8_t>{lines.by() == By::surface});
  out.write("lines/replicate_count", std::vector<uint64_t>{lines.replicateCount()});
  out.write("lines/least_form_factor", std::vector<double>{lines.leastFormFactor()});
  const std::vector<bool>& leaking = lines.leakingFaces().of_face;
  out.write("lines/leaking", std::vector<uint8_t>(leaking.begin(), leaking.end()));
  writeFlags(out, "lines/leak_backs", lines.leakingFaces().backs);
  out.write("lines/leak_rays", std::vector<uint32_t>{lines.leakingFaces().rays});
  const auto& pairs = lines.pairs();
  writeColumn<uint32_t>(out, "lines/i", pairs, [](const LinePair& pair) { return pair.i; });
  writeColumn<uint32_t>(out, "lines/j", pairs, [](const LinePair& pair) { return pair.j; });
  writeColumn<double>(out, "lines/exchange", pairs, [](const LinePair& pair) { return pair.exchange; });
  writeColumn<double>(out, "lines/clear", pairs, [](const LinePair& pair) { return pair.clear; });
  writeColumn<double>(out, "lines/error", pairs, [](const LinePair& pair) { return pair.error; });
  writeColumn<uint32_t>(out, "lines/blocks", pairs, [](const LinePair& pair) { return pair.blocks; });
  writeColumn<uint32_t>(out, "lines/period", pairs, [](const LinePair& pair) { return pair.period; });
  writeColumn<uint8_t>(out, "lines/by_angles", pairs, [](const LinePair& pair) { return pair.by_angles; });
  writeColumn<uint32_t>(out, "lines/cuts", pairs, [](const LinePair& pair) { return pair.cuts; });
  writeColumn<uint32_t>(out, "lines/parts", pairs, [](const LinePair& pair) { return pair.parts; });
  const auto sumOf = [&lines](const LinePair& pair) -> const LineSum& {
    return lines.sumOf(&pair - lines.pairs().data());
  };
  writeColumn<uint64_t>(out, "lines/facing", pairs, [sumOf](const LinePair& pair) { return sumOf(pair).facing; });
  writeColumn<uint64_t>(out, "lines/all", pairs, [sumOf](const LinePair& pair) { return sumOf(pair).all; });
  writeColumn<uint64_t>(out, "lines/effective", pairs, [sumOf](const LinePair& pair) { return sumOf(pair).effective; });
  writeColumn<uint64_t>(out, "lines/facing_squares", pairs,
                        [sumOf](const LinePair& pair) { return sumOf(pair).facing_squares; });
  writeColumn<uint64_t>(out, "lines/products", pairs, [sumOf](const LinePair& pair) { return sumOf(pair).products; });
  writeColumn<uint64_t>(out, "lines/all_squares", pairs,
                        [sumOf](const LinePair& pair) { return sumOf(pair).all_squares; });
  writeColumn<uint64_t>(out, "lines/drawn_blocks", pairs, [sumOf](const LinePair& pair) { return sumOf(pair).blocks; });
  writeColumn<uint32_t>(out, "lines/replicates", pairs,
                        [sumOf](const LinePair& pair) { return sumOf(pair).replicates; });
}

ReplicateSums readReplicateSums(Hdf5Input& in, const std::string& group) {
  Ids ids;
  ids.names = in.read<std::string>(group + "/names");
  ids.areas.resize(ids.count());
  ids.surface.resize(ids.count());
  readColumn<double>(in, group + "/areas", ids.areas, [](double& area, double stored) { area = stored; });
  readColumn<uint32_t>(in, group + "/surfaces", ids.surface,
                       [](uint32_t& surface, uint32_t stored) { surface = stored; });
  for (uint8_t requested : in.read<uint8_t>(group + "/requested")) ids.requested.push_back(requested);
  if (!ids.requested.empty() && ids.requested.size() != ids.count())
    in.refuse(fmt::format("its '{}/requested' has {} values for {}", group, ids.requested.size(), ids.count()));
  ids.only_blocks = readFlags(in, group + "/only_blocks", ids.count());
  ids.splits_surfaces = readOne<uint8_t>(in, group + "/splits_surfaces");
  ids.rows_sum_to_one = readOne<uint8_t>(in, group + "/rows_sum_to_one");
  ids.two_sided = readOne<uint8_t>(in, group + "/two_sided");
  ids.empty_rows = readEmptyRows(in, group, ids.count());
  const auto replicate_count = readOne<uint64_t>(in, group + "/replicate_count");
  std::vector<Sum> rows(ids.count());
  readSums(in, group + "/rows", rows, [](Sum& sum) -> Sum& { return sum; });
  std::vector<PairSum> pairs;
  for (uint32_t i : in.read<uint32_t>(group + "/pairs/i")) pairs.push_back({i, 0, {}});
  readColumn<uint32_t>(in, group + "/pairs/j", pairs, [](PairSum& pair, uint32_t j) { pair.j = j; });
  readSums(in, group + "/pairs", pairs, [](PairSum& pair) -> Sum& { return pair.sum; });
  requireOrder(in, group + "/pairs", pairs, ids.count());
  FurtherReplicates further;
  if (in.has(group + "/further/replicate_count")) {
    further.replicates = readOne<uint64_t>(in, group + "/further/replicate_count");
    further.of_rows = in.read<uint64_t>(group + "/further/of_rows", ids.count());
    if (further.replicates >= replicate_count ||
        std::ranges::any_of(further.of_rows, [&](uint64_t of_row) { return of_row > further.replicates; }))
      in.refuse(fmt::format("its '{}/further' does not agree with its replicates", group));
  }
  return {std::move(ids), replicate_count, std::move(pairs), std::move(rows), std::move(further)};
}

std::optional<PriorSums> readPriorSums(Hdf5Input& in, const Ids& face_ids, const Ids& surface_ids) {
  if (!readOne<uint8_t>(in, "prior/is_there")) return {};
  Prior prior;
  prior.has_all_pairs = readOne<uint8_t>(in, "prior/has_all_pairs");
  prior.lines.resize(face_ids.count());
  readColumn<uint64_t>(in, "prior/lines", prior.lines, [](uint64_t& line, uint64_t stored) { line = stored; });
  prior.ranks = in.read<uint32_t>("prior/ranks");
  std::vector<bool> is_taken(face_ids.count(), false);
  for (uint32_t rank : prior.ranks) {
    if (rank >= is_taken.size() || is_taken[rank]) in.refuse("its 'prior/ranks' are no order of its ids");
    is_taken[rank] = true;
  }
  if (pairCount(prior.ranks.size()) > kMostRowPairs)
    in.refuse("its 'prior/ranks' are of more ids than may have neighbours");
  if (!prior.ranks.empty() && prior.ranks.size() != face_ids.count())
    in.refuse(fmt::format("its 'prior/ranks' has {} values for {}", prior.ranks.size(), face_ids.count()));
  for (uint32_t i : in.read<uint32_t>("prior/pairs/i")) prior.pairs.push_back({i, 0});
  readColumn<uint32_t>(in, "prior/pairs/j", prior.pairs, [](PairPrior& pair, uint32_t j) { pair.j = j; });
  readColumn<uint32_t>(in, "prior/pairs/visibility", prior.pairs,
                       [](PairPrior& pair, uint32_t visibility) { pair.visibility = visibility; });
  readColumn<uint32_t>(in, "prior/pairs/surface_visibility", prior.pairs,
                       [](PairPrior& pair, uint32_t visibility) { pair.surface_visibility = visibility; });
  readColumn<double>(in, "prior/pairs/exchange", prior.pairs,
                     [](PairPrior& pair, double exchange) { pair.exchange = exchange; });
  requireOrder(in, "prior/pairs", prior.pairs, face_ids.count());
  const bool are_visibilities = std::ranges::all_of(prior.pairs, [](const PairPrior& pair) {
    return pair.visibility <= kVisibilityOne && pair.surface_visibility <= kVisibilityOne && pair.exchange >= 0;
  });
  if (!are_visibilities) in.refuse("its 'prior/pairs' are no visibilities of exchange areas");
  for (uint32_t i : in.read<uint32_t>("prior/pairs/directed/i")) prior.directed.push_back({i, 0});
  readColumn<uint32_t>(in, "prior/pairs/directed/j", prior.directed,
                       [](DirectedPair& pair, uint32_t j) { pair.j = j; });
  readColumn<uint32_t>(in, "prior/pairs/directed/directions", prior.directed,
                       [](DirectedPair& pair, uint32_t directions) { pair.directions = directions; });
  readColumn<uint32_t>(in, "prior/pairs/directed/resolution", prior.directed,
                       [](DirectedPair& pair, uint32_t resolution) { pair.resolution = resolution; });
  readColumn<uint32_t>(in, "prior/pairs/directed/visibility", prior.directed,
                       [](DirectedPair& pair, uint32_t visibility) { pair.visibility = visibility; });
  readColumn<uint32_t>(in, "prior/pairs/directed/line", prior.directed,
                       [](DirectedPair& pair, uint32_t line) { pair.line = line; });
  readColumn<double>(in, "prior/pairs/directed/measure_area", prior.directed,
                     [](DirectedPair& pair, double area) { pair.measure_area = area; });
  readColumn<double>(in, "prior/pairs/directed/count_area", prior.directed,
                     [](DirectedPair& pair, double area) { pair.count_area = area; });
  requireOrder(in, "prior/pairs/directed", prior.directed, face_ids.count());
  const bool are_prior_pairs = std::ranges::all_of(prior.directed, [&](const DirectedPair& pair) {
    return pair.j < kEnvironment && pair.directions > 0 && pair.visibility <= kVisibilityOne &&
           std::ranges::binary_search(prior.pairs, keyOf(pair), {}, keyOf<PairPrior>);
  });
  if (!are_prior_pairs) in.refuse("its 'prior/pairs/directed' are none of its pairs");
  const By by = readOne<uint8_t>(in, "prior/by_surface") ? By::surface : By::polygon;
  VisibilitySums by_face = readVisibilitySums(in, "prior/faces", face_ids);
  ControlVariateSums by_surface = readControlSums(in, "prior/surfaces", surface_ids),
                     directed = readControlSums(in, "prior/directed", face_ids);
  return PriorSums(by, std::move(prior), std::move(by_face), std::move(by_surface), std::move(directed));
}

std::optional<LineSums> readLineSums(Hdf5Input& in, const Ids& face_ids) {
  if (!in.has("lines/i")) return {};
  std::vector<LinePair> pairs;
  for (uint32_t i : in.read<uint32_t>("lines/i")) pairs.push_back({i, 0});
  readColumn<uint32_t>(in, "lines/j", pairs, [](LinePair& pair, uint32_t j) { pair.j = j; });
  readColumn<double>(in, "lines/exchange", pairs, [](LinePair& pair, double area) { pair.exchange = area; });
  readColumn<double>(in, "lines/clear", pairs, [](LinePair& pair, double area) { pair.clear = area; });
  // A file without the column lines/error has exchange areas that are good to 1e-6 (kUnoccludedRelativeError).
  for (LinePair& pair : pairs) pair.error = 1e-6 * pair.exchange;
  if (in.has("lines/error"))
    readColumn<double>(in, "lines/error", pairs, [](LinePair& pair, double error) { pair.error = error; });
  readColumn<uint32_t>(in, "lines/blocks", pairs, [](LinePair& pair, uint32_t blocks) { pair.blocks = blocks; });
  readColumn<uint32_t>(in, "lines/period", pairs, [](LinePair& pair, uint32_t period) { pair.period = period; });
  readColumn<uint8_t>(in, "lines/by_angles", pairs, [](LinePair& pair, uint8_t is) { pair.by_angles = is; });
  readColumn<uint32_t>(in, "lines/cuts", pairs, [](LinePair& pair, uint32_t cuts) { pair.cuts = cuts; });
  readColumn<uint32_t>(in, "lines/parts", pairs, [](LinePair& pair, uint32_t parts) { pair.parts = parts; });
  requireOrder(in, "lines", pairs, 2 * face_ids.count());  // pairs with backs included
  const bool are_sound = std::ranges::all_of(pairs, [&](const LinePair& pair) {
    return pair.i < face_ids.count() && pair.i < pair.j && pair.j < kEnvironment && pair.period > 0 &&
           pair.exchange >= pair.clear && pair.clear >= 0 && std::isfinite(pair.exchange) && pair.error >= 0 &&
           std::isfinite(pair.error) && pair.blocks <= kMostLineBlocks && pair.cuts <= kMostCuts;
  });
  if (!are_sound) in.refuse("its 'lines' are no pairs with lines");
  std::vector<LineSum> sums(pairs.size());
  readColumn<uint64_t>(in, "lines/facing", sums, [](LineSum& sum, uint64_t word) { sum.facing = word; });
  readColumn<uint64_t>(in, "lines/all", sums, [](LineSum& sum, uint64_t word) { sum.all = word; });
  readColumn<uint64_t>(in, "lines/effective", sums, [](LineSum& sum, uint64_t word) { sum.effective = word; });
  readColumn<uint64_t>(in, "lines/facing_squares", sums,
                       [](LineSum& sum, uint64_t word) { sum.facing_squares = word; });
  readColumn<uint64_t>(in, "lines/products", sums, [](LineSum& sum, uint64_t word) { sum.products = word; });
  readColumn<uint64_t>(in, "lines/all_squares", sums, [](LineSum& sum, uint64_t word) { sum.all_squares = word; });
  readColumn<uint64_t>(in, "lines/drawn_blocks", sums, [](LineSum& sum, uint64_t blocks) { sum.blocks = blocks; });
  readColumn<uint32_t>(in, "lines/replicates", sums, [](LineSum& sum, uint32_t count) { sum.replicates = count; });
  const bool are_whole = std::ranges::all_of(
      sums, [](const LineSum& sum) { return sum.facing <= sum.all && sum.all <= uint64_t(sum.replicates) << 31; });
  if (!are_whole) in.refuse("its 'lines' are no sums of lines");
  const By by = readOne<uint8_t>(in, "lines/by_surface") ? By::surface : By::polygon;
  const auto replicate_count = readOne<uint64_t>(in, "lines/replicate_count");
  const auto least = readOne<double>(in, "lines/least_form_factor");
  if (!(least >= 0 && least <= 1)) in.refuse("its 'lines/least_form_factor' is no form factor");
  const auto hasBack = [&](const LinePair& pair) { return pair.j >= face_ids.count(); };
  if (least > 0 && std::ranges::any_of(pairs, hasBack))
    in.refuse("its 'lines' have backs, although 'lines/least_form_factor' is above 0");
  const std::vector<uint8_t> leaking = in.read<uint8_t>("lines/leaking");
  if (!leaking.empty() && leaking.size() != face_ids.count()) in.refuse("its 'lines/leaking' is not of its faces");
  const auto mayHave = [&](const LinePair& pair) { return !hasBack(pair) || (!leaking.empty() && leaking[pair.i]); };
  if (!std::ranges::all_of(pairs, mayHave))
    in.refuse("its 'lines' have backs of faces that 'lines/leaking' leaves out");
  LeakingFaces leaking_faces{{leaking.begin(), leaking.end()},
                             readOne<uint32_t>(in, "lines/leak_rays"),
                             readFlags(in, "lines/leak_backs", face_ids.count())};
  return LineSums(face_ids, by, std::move(pairs), least, std::move(leaking_faces), sums, replicate_count);
}

}  // namespace viewpeel
