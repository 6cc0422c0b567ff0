// Checkpoints are read back to the same bits, and damaged or foreign files are refused.
#include "io/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <viewpeel/error.h>
#include "estimator/estimate.h"
#include "io/hdf5_input.h"
#include "io/hdf5_output.h"
#include "scenes/named_scenes.h"
#include "tests/support/checkpoint_file.h"

namespace viewpeel {
namespace {

void overwrite(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

template <class Use>
std::string messageOf(Use use) {
  try {
    use();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// Of three replicates the last one has rays of row 1 alone, for its environment.
TEST_F(CheckpointFile, ReadsBackReplicatesOfSomeRows) {
  Settings settings = kSettings;
  settings.emplace_back("--rays", "on");
  std::vector<bool> rows(ids_.count());
  rows[1] = true;
  const auto addFurther = [&](RunSums& sums) {
    sums.by_id.addOutside({{1, kEnvironment, 40}}, rows);
    sums.by_surface.addOutside({}, {});
    sums.replicates = {{0, sums.replicateCount()}};
    sums.directions += 16;
  };
  RunSums sums = makeRunSums(scene_, ids_);
  sums.measure_area = 1 / 3.0;
  std::vector<uint32_t> rays(ids_.count(), 16);
  rays[0] = 32;
  sums.countRays(rays);
  RunSums without_whole = sums;
  for (const uint64_t replicate : {0, 1}) sums.add(replicate, randomCounts(ids_, replicate), 16);
  addFurther(sums);
  writeCheckpoint(settings, sums, file("rays.h5"));
  const RunSums read = readCheckpoint(file("rays.h5")).sums;
  EXPECT_EQ(read.rays, rays);
  EXPECT_EQ(read.by_id.replicatesOf(0, 1), 2u);
  EXPECT_EQ(read.by_id.replicatesOf(0, kEnvironment), 2u);
  EXPECT_EQ(read.by_id.replicatesOf(1, kEnvironment), 3u);
  const FormFactors a = sums.formFactors(), b = read.formFactors();
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (size_t k = 0; k < a.entries().size(); ++k) {
    EXPECT_EQ(a.entries()[k].exchange_area.value, b.entries()[k].exchange_area.value);
    EXPECT_EQ(a.entries()[k].exchange_area.standard_error, b.entries()[k].exchange_area.standard_error);
  }
  addFurther(without_whole);
  writeCheckpoint(settings, without_whole, file("without.h5"));
  EXPECT_NE(messageOf([&] { readCheckpoint(file("without.h5")); }).find("does not agree with its replicates"),
            std::string::npos);
}

TEST_F(CheckpointFile, ReadsBackEveryBit) {
  Ids ids = ids_;
  restrictToQuestion({.from = {"upper box"}}, scene_, ids);
  ids.names[0] = "wall, \"nörth\"";
  RunSums sums = makeRunSums(scene_, ids);
  sums.measure_area = 1 / 3.0;
  for (uint64_t replicate : {3, 4, 9}) sums.add(replicate, randomCounts(ids, replicate), 10);
  writeCheckpoint(kSettings, sums, file("a.h5"));
  const Checkpoint read = readCheckpoint(file("a.h5"));
  EXPECT_EQ(read.settings, kSettings);
  EXPECT_EQ(findSetting(read.settings, "--seed"), "7");
  EXPECT_EQ(findSetting(read.settings, "--from"), "");
  EXPECT_EQ(findSetting(read.settings, "--see"), std::nullopt);
  EXPECT_EQ(read.sums.measure_area, 1 / 3.0);
  EXPECT_EQ(read.sums.directions, 30u);
  EXPECT_EQ(read.sums.replicates, (std::vector<ReplicateRange>{{3, 5}, {9, 10}}));
  bool passes_64_bits = false;
  for (const auto& [a, b] : {std::pair(&sums.by_id, &read.sums.by_id), {&sums.by_surface, &read.sums.by_surface}}) {
    EXPECT_EQ(a->ids().names, b->ids().names);
    EXPECT_EQ(a->ids().areas, b->ids().areas);
    EXPECT_EQ(a->ids().surface, b->ids().surface);
    EXPECT_EQ(a->ids().requested, b->ids().requested);
    EXPECT_EQ(a->ids().splits_surfaces, b->ids().splits_surfaces);
    EXPECT_EQ(a->ids().rows_sum_to_one, b->ids().rows_sum_to_one);
    EXPECT_EQ(a->replicateCount(), b->replicateCount());
    ASSERT_EQ(a->pairs().size(), b->pairs().size());
    ASSERT_GT(a->pairs().size(), 10u);
    for (auto of_a = a->pairs().begin(), of_b = b->pairs().begin(); of_a != a->pairs().end(); ++of_a, ++of_b) {
      const ReplicateSums::PairSum &x = *of_a, &y = *of_b;
      EXPECT_TRUE(x.i == y.i && x.j == y.j && x.sum.sum == y.sum.sum && x.sum.sum_of_squares == y.sum.sum_of_squares)
          << x.i << ", " << x.j;
      passes_64_bits = passes_64_bits || x.sum.sum_of_squares >> 64;
    }
    ASSERT_EQ(a->rowSums().size(), b->rowSums().size());
    for (size_t k = 0; k < a->rowSums().size(); ++k)
      EXPECT_TRUE(a->rowSums()[k].sum == b->rowSums()[k].sum &&
                  a->rowSums()[k].sum_of_squares == b->rowSums()[k].sum_of_squares)
          << k;
  }
  EXPECT_TRUE(passes_64_bits);
}

// Older checkpoints hold the setting --unoccluded under its older name.
TEST_F(CheckpointFile, OlderNamesOfSettingsAreRead) {
  writeCheckpoint({{"--closed-forms", "on"}}, makeRunSums(scene_, ids_), file("old.h5"));
  EXPECT_EQ(readCheckpoint(file("old.h5")).settings, (Settings{{"--unoccluded", "on"}}));
}

TEST_F(CheckpointFile, PartsInAnyOrderAddUpToOneRun) {
  const std::string whole = bytesOf(sumsOf({0, 1, 2, 3, 4, 5, 6}));
  const std::vector<std::vector<uint64_t>> parts = {{0, 1}, {2}, {3, 5}, {4, 6}};
  std::vector<fs::path> files;
  for (size_t k = 0; k < parts.size(); ++k) {
    files.push_back(file("part" + std::to_string(k) + ".h5"));
    writeCheckpoint(kSettings, sumsOf(parts[k]), files.back());
  }
  do {
    const Checkpoint merged = mergeCheckpoints(files);
    EXPECT_EQ(bytesOf(merged.sums), whole) << files[0] << files[1] << files[2] << files[3];
    EXPECT_EQ(merged.sums.replicates, (std::vector<ReplicateRange>{{0, 7}}));
  } while (std::next_permutation(files.begin(), files.end()));
  EXPECT_NE(bytesOf(sumsOf({0, 1, 2, 3, 4, 5, 7})), whole);  // negative control: another replicate gives other bytes
}

TEST_F(CheckpointFile, WhatDoesNotBelongTogetherIsRefused) {
  writeCheckpoint(kSettings, sumsOf({0, 1, 2}), file("a.h5"));
  writeCheckpoint(kSettings, sumsOf({2, 3}), file("b.h5"));
  writeCheckpoint({{"version", "1"}, {"--seed", "8"}, {"--from", ""}}, sumsOf({5}), file("c.h5"));
  writeCheckpoint({{"version", "1"}, {"--seed", "7"}}, sumsOf({5}), file("d.h5"));
  RunSums other_area = sumsOf({5});
  other_area.measure_area = std::nextafter(other_area.measure_area, 1);
  writeCheckpoint(kSettings, other_area, file("e.h5"));
  const auto merge = [&](const char* with) { return messageOf([&] { mergeCheckpoints({file("a.h5"), file(with)}); }); };
  EXPECT_NE(merge("b.h5").find("b.h5: an earlier file has its replicates 2 to 2, too"), std::string::npos)
      << merge("b.h5");
  EXPECT_NE(merge("c.h5").find("--seed is '8' there, '7' here"), std::string::npos) << merge("c.h5");
  EXPECT_NE(merge("d.h5").find("--from is 'not set' there, '' here"), std::string::npos) << merge("d.h5");
  EXPECT_NE(merge("e.h5").find("areas"), std::string::npos) << merge("e.h5");
}

// A replicate that two files hold counts once. The merged file has the bytes of the file with all replicates.
TEST_F(CheckpointFile, ReplicatesInTwoFilesCountOnce) {
  const std::string whole = bytesOf(sumsOf({0, 1, 2, 3}));
  writeCheckpoint(kSettings, sumsOf({0, 1, 2, 3}), file("all.h5"));
  writeCheckpoint(kSettings, sumsOf({1, 2}), file("some.h5"));
  writeCheckpoint(kSettings, sumsOf({0, 3}), file("ends.h5"));
  writeCheckpoint(kSettings, sumsOf({3, 4}), file("beyond.h5"));
  const std::vector<std::vector<const char*>> orders = {{"all.h5", "some.h5"},  {"some.h5", "all.h5"},
                                                        {"all.h5", "all.h5"},   {"ends.h5", "all.h5"},
                                                        {"some.h5", "ends.h5"}, {"some.h5", "ends.h5", "some.h5"}};
  for (const auto& order : orders) {
    std::vector<std::filesystem::path> files;
    for (const char* name : order) files.push_back(file(name));
    EXPECT_EQ(bytesOf(mergeCheckpoints(files).sums), whole) << order[0] << ", " << order[1];
  }
  EXPECT_THROW(mergeCheckpoints({file("all.h5"), file("beyond.h5")}), Error);
}

// Sums of pair lines, between two faces or from a face to a back, are the same after writing and reading. Parts add up
// to the bytes of the whole in any order. A file in which a pair has another number of lines belongs to another run and
// is refused.
TEST_F(CheckpointFile, PairLinesAddUpToOneRun) {
  const auto sumsWithLines = [&](const std::vector<uint64_t>& replicates, uint32_t blocks = 3,
                                 uint32_t leaking_face = 1) {
    const std::vector<LinePair> pairs = {
        {0, 1, 0.4, 0.4}, {0, 2, 0.5, 0.1, 1e-9, blocks}, {1, ids_.count() + 2, 0.25, 0, 0, 1, 2, true}};
    RunSums sums = makeRunSums(scene_, ids_);
    LeakingFaces leaking{std::vector<bool>(ids_.count()), 64};
    leaking.of_face[leaking_face] = true;
    sums.lines.emplace(ids_, By::polygon, pairs, 0, leaking);
    sums.measure_area = 0.1;
    for (const uint64_t replicate : replicates)
      sums.addLines(replicate, {{0, kEnvironment, 5 + replicate, 0}}, 10,
                    {{1, blocks, 600'000 + uint32_t(replicate), 1'000'000 + 7 * uint32_t(replicate), 40 * 256},
                     {2, 1, 300'000, 1'100'000, 15 * 256}});
    return sums;
  };
  const RunSums sums = sumsWithLines({0, 1, 2, 3});
  const std::string whole = bytesOf(sums);
  const Checkpoint read = readCheckpoint(file("bytes.h5"));
  ASSERT_TRUE(read.sums.lines);
  EXPECT_EQ(read.sums.lines->pairs(), sums.lines->pairs());
  EXPECT_EQ(read.sums.lines->sums(), sums.lines->sums());
  EXPECT_TRUE(read.sums.lines->hasBack(2));
  EXPECT_EQ(read.sums.lines->leakingFaces(), sums.lines->leakingFaces());
  const FormFactors found = read.sums.formFactors();
  EXPECT_EQ(found.exchangeArea(0, 1).value, 0.4);
  EXPECT_NEAR(found.exchangeArea(0, 2).value, 0.1 + 0.6 * 0.4, 1e-5);
  EXPECT_NEAR(found.exchangeArea(1, kLeak).value, 0.25 * 3 / 11, 1e-12);
  EXPECT_GT(found.exchangeArea(0, kEnvironment).value, 0);

  writeCheckpoint(kSettings, sumsWithLines({0, 2}), file("a.h5"));
  writeCheckpoint(kSettings, sumsWithLines({1, 3}), file("b.h5"));
  EXPECT_EQ(bytesOf(mergeCheckpoints({file("a.h5"), file("b.h5")}).sums), whole);
  EXPECT_EQ(bytesOf(mergeCheckpoints({file("b.h5"), file("a.h5")}).sums), whole);
  writeCheckpoint(kSettings, sumsWithLines({1, 3}, 4), file("c.h5"));
  EXPECT_THROW(mergeCheckpoints({file("a.h5"), file("c.h5")}), Error);
  writeCheckpoint(kSettings, sumsWithLines({1, 3}, 3, 0), file("d.h5"));
  EXPECT_NE(messageOf([&] { readCheckpoint(file("d.h5")); }).find("'lines/leaking' leaves out"), std::string::npos);
}

// In a mixture common directions count the pairs that have no lines, and lines that end on backs. Files of which one
// has lines for other pairs are not of one run.
TEST_F(CheckpointFile, MixturesHaveEachPairOnce) {
  const auto write = [&](const char* name, double least, uint32_t j, uint32_t counted) {
    RunSums sums = makeRunSums(scene_, ids_);
    sums.lines.emplace(ids_, By::polygon, std::vector<LinePair>{{0, j, 0.5, 0.1, 1e-9, 3}}, least);
    sums.measure_area = 0.1;
    const uint64_t replicate = name[0];
    sums.addLines(replicate, {{0, counted, 5, 0}}, 10, {{0, 3, 600'000, 1'000'000, 40 * 256}});
    writeCheckpoint(kSettings, sums, file(name));
    return file(name);
  };
  const FormFactors found = readCheckpoint(write("a.h5", 0.01, 2, 3)).sums.formFactors();
  EXPECT_EQ(found.entries().size(), 2u);
  EXPECT_GT(found.exchangeArea(0, 2).value, 0.1);
  EXPECT_GT(found.exchangeArea(0, 3).value, 0);
  EXPECT_NO_THROW(mergeCheckpoints({file("a.h5"), write("b.h5", 0.01, 2, 4)}));
  EXPECT_THROW(mergeCheckpoints({file("a.h5"), write("c.h5", 0.02, 2, 3)}), Error);
  EXPECT_NE(messageOf([&] { readCheckpoint(write("d.h5", 0.01, 2, 2)); }).find("counted by common"), std::string::npos);
  EXPECT_NE(messageOf([&] { readCheckpoint(write("e.h5", 0.01, ids_.count() + 2, 3)); }).find("have backs"),
            std::string::npos);
}

// Merged parts of a run with priors have the bytes of one run: control variates are integers, and all parts have the
// same visibilities. Unoccluded form factors may differ in the last bits from device to device. In any order of files
// the first replicate's values are kept.
TEST_F(CheckpointFile, ControlsAddUpToOneRun) {
  const auto sumsWithPrior = [&](const std::vector<uint64_t>& replicates, uint32_t one_visibility = 0,
                                 uint32_t directions = 16) {
    Prior prior{{}, std::vector<uint64_t>(ids_.count(), 16), true};
    std::mt19937_64 random(4);
    for (uint32_t i = 0; i < ids_.count(); ++i)
      for (uint32_t j = i + 1; j < ids_.count(); ++j)
        if (random() % 2)
          prior.pairs.push_back({i, j, static_cast<uint32_t>(random() % kVisibilityOne),
                                 static_cast<uint32_t>(random() % 2 * 3077),
                                 replicates[0] == 0 ? 0.1 : std::nextafter(0.1, 1)});
    if (one_visibility) prior.pairs[3].visibility = one_visibility;
    prior.directed = {
        {prior.pairs[2].i, prior.pairs[2].j, directions, 200, 1000, 1, 0.01, 0.2},
        {prior.pairs[9].i, prior.pairs[9].j, 32, 300, 0, 4, replicates[0] == 0 ? 0.1 : std::nextafter(0.1, 1), 0.2}};
    RunSums sums = makeRunSums(scene_, ids_);
    sums.prior_sums.emplace(ids_, sums.by_surface.ids(), By::polygon, prior);
    sums.measure_area = 0.1;
    for (uint64_t replicate : replicates) {
      PairCounts counts = randomCounts(ids_, replicate);
      for (PairCount& count : counts)
        count = {count.i, count.j, count.count >> 8, count.j < kEnvironment ? count.count % 1'000'003 << 20 : 0};
      const PairCounts directed{{prior.pairs[2].i, prior.pairs[2].j, replicate * 3, 700},
                                {prior.pairs[9].i, prior.pairs[9].j, 1 + replicate % 3, replicate}};
      sums.add(replicate, counts, 10, directed);
    }
    return sums;
  };
  const RunSums sums = sumsWithPrior({0, 1, 2, 3, 4, 5, 6});
  const std::string whole = bytesOf(sums);
  const Checkpoint read = readCheckpoint(file("bytes.h5"));
  ASSERT_TRUE(read.sums.prior_sums);
  ASSERT_EQ(read.sums.prior_sums->directed().pairs().size(), 2u);
  EXPECT_EQ(read.sums.prior_sums->prior(), sums.prior_sums->prior());
  EXPECT_TRUE(std::ranges::any_of(sums.prior_sums->directed().pairs(), [](const auto& pair) { return pair.sum < 0; }));
  EXPECT_TRUE(std::ranges::any_of(sums.prior_sums->byFace().pairs(), [&](const auto& pair) {
    return sums.prior_sums->byFace().squaresOf(pair).blocked >> 64;
  }));
  const FormFactors a = sums.formFactors(), b = read.sums.formFactors();
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (size_t k = 0; k < a.entries().size(); ++k) {
    EXPECT_EQ(a.entries()[k].exchange_area.value, b.entries()[k].exchange_area.value);
    EXPECT_EQ(a.entries()[k].exchange_area.standard_error, b.entries()[k].exchange_area.standard_error);
  }
  std::vector<fs::path> files;
  for (const std::vector<uint64_t>& part : {std::vector<uint64_t>{0, 1}, {2}, {3, 5}, {4, 6}}) {
    files.push_back(file("part" + std::to_string(files.size()) + ".h5"));
    writeCheckpoint(kSettings, sumsWithPrior(part), files.back());
  }
  do EXPECT_EQ(bytesOf(mergeCheckpoints(files).sums), whole) << files[0] << files[1] << files[2] << files[3];
  while (std::next_permutation(files.begin(), files.end()));
  RunSums twice = sums;
  twice.by_id = sumsOf({0, 1, 2, 3, 4, 5, 6}).by_id;
  writeCheckpoint(kSettings, twice, file("twice.h5"));
  EXPECT_NE(messageOf([&] { readCheckpoint(file("twice.h5")); }).find("does not agree with its sums"),
            std::string::npos)
      << "pairs that are summed twice";
  writeCheckpoint(kSettings, sumsWithPrior({9}, 5), file("other.h5"));
  writeCheckpoint(kSettings, sumsWithPrior({9}, 0, 17), file("directed.h5"));
  writeCheckpoint(kSettings, sumsOf({9}), file("without.h5"));
  for (const auto& [name, reason] : {std::pair("other.h5", "other visibilities"),
                                     {"without.h5", "other visibilities"},
                                     {"directed.h5", "give all parts of a run the same goal"}}) {
    const std::vector<fs::path> apart = {file("part0.h5"), file(name)};
    const std::string message = messageOf([&] { mergeCheckpoints(apart); });
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }
}

// A file that is cut off anywhere, or has any bit changed, is refused.
TEST_F(CheckpointFile, DamageIsFound) {
  const std::string whole = bytesOf(sumsOf({0, 1}));
  constexpr uint64_t kSeed = 5;
  std::mt19937_64 random(kSeed);
  constexpr int kTrials = 1500;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::string damaged = whole;
    const size_t at = random() % whole.size();
    const int bit = static_cast<int>(random() % 8);
    if (trial % 10 == 0) damaged.resize(at);
    else damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
    overwrite(file("damaged.h5"), damaged);
    const std::string message = messageOf([&] { readCheckpoint(file("damaged.h5")); });
    EXPECT_NE(message.find("damaged.h5: not a whole checkpoint"), std::string::npos)
        << message << ": byte " << at << ", bit " << bit << ", seed " << kSeed;
  }
  overwrite(file("damaged.h5"), whole);
  EXPECT_EQ(bytesOf(readCheckpoint(file("damaged.h5")).sums), whole);
}

TEST_F(CheckpointFile, OtherFilesAreRefused) {
  overwrite(file("empty.h5"), "");
  overwrite(file("text.h5"), "from,to,form_factor\n");
  const auto write = [&](const char* name, const auto&... columns) {
    Hdf5Output out;
    (out.write(columns.first, columns.second), ...);
    const std::vector<char> bytes = out.finish();
    overwrite(file(name), {bytes.begin(), bytes.end()});
  };
  write("other.h5", std::pair("temperatures", std::vector<double>{1, 2}));
  write("later.h5", std::pair("format", std::vector<uint64_t>{1000}));
  write("short.h5", std::pair("format", std::vector<uint64_t>{10}),
        std::pair("settings/names", std::vector<std::string>{"--seed"}),
        std::pair("settings/values", std::vector<std::string>{"1", "2"}));
  const auto message = [&](const char* name) { return messageOf([&] { readCheckpoint(file(name)); }); };
  EXPECT_NE(message("missing.h5").find("No such file"), std::string::npos) << message("missing.h5");
  EXPECT_NE(message(".").find("not a regular file"), std::string::npos) << message(".");
  EXPECT_NE(message("empty.h5").find("another file"), std::string::npos) << message("empty.h5");
  EXPECT_NE(message("text.h5").find("another file"), std::string::npos) << message("text.h5");
  EXPECT_NE(message("other.h5").find("'format'"), std::string::npos) << message("other.h5");
  EXPECT_NE(message("later.h5").find("format 1000"), std::string::npos) << message("later.h5");
  EXPECT_NE(message("short.h5").find("2 values for 1"), std::string::npos) << message("short.h5");
}

// Columns that are made while the file is written are read like others, and the check sum holds for their bytes, too.
// Sizes are not multiples of the check sum's words, and one column has more bytes than a block of ByteSink.
TEST_F(CheckpointFile, ColumnsMayBeMadeWhileTheFileIsWritten) {
  static constexpr size_t kMany = 100'003;
  const std::vector<int32_t> before{1, 2, 3};
  const std::vector<double> after{0.5, -2};
  const auto fill = [&](Hdf5Output& out) {
    out.write("before", before);
    out.writeLater<uint8_t>("group/bytes", 5, [](ByteSink& sink) {
      for (uint8_t k = 0; k < 5; ++k) sink.put(k);
    });
    out.writeLater<double>("group/many", kMany, [](ByteSink& sink) {
      for (size_t k = 0; k < kMany; ++k) sink.put(1 / double(k + 1));
    });
    out.writeLater<int64_t>("none", 0, [](ByteSink&) {});
    out.write("after", after);
    out.makeScale("before");
    out.useScale("group/many", "before");
  };
  Hdf5Output out;
  fill(out);
  std::ofstream stream(file("made.h5"), std::ios::binary);
  out.finish(stream);
  stream.close();
  Hdf5Input in(file("made.h5"));
  EXPECT_EQ(in.read<int32_t>("before"), before);
  EXPECT_EQ(in.read<double>("after"), after);
  EXPECT_EQ(in.read<uint8_t>("group/bytes"), (std::vector<uint8_t>{0, 1, 2, 3, 4}));
  EXPECT_TRUE(in.read<int64_t>("none").empty());
  const std::vector<double> many = in.read<double>("group/many", kMany);
  for (size_t k = 0; k < kMany; ++k) ASSERT_EQ(many[k], 1 / double(k + 1));

  // Where the size of files is limited HDF5 has a buffer, and the bytes are the same.
  rlimit limit{}, limited{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  limited = {.rlim_cur = 1 << 30, .rlim_max = limit.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limited), 0);
  {
    Hdf5Output buffered;
    fill(buffered);
    const std::vector<char> bytes = buffered.finish();
    std::ifstream made(file("made.h5"), std::ios::binary);
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), std::istreambuf_iterator<char>(made), {}));
  }
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);

  Hdf5Output wrong;
  wrong.writeLater<int32_t>("short", 2, [](ByteSink& sink) { sink.put(int32_t(1)); });
  EXPECT_THROW(wrong.finish(), Error);
}

TEST(Fingerprint, ChangesWithAnyBitButNotWithThePlaceOfTheFile) {
  const InputScene room = ts::roomWithTouchingBoxes();
  const auto of = [](const InputScene& input) { return fingerprint(buildScene(input)); };
  InputScene moved = room, renamed = room, swapped = room;
  moved.file = "elsewhere.obj";
  renamed.surface_names[0] += "'";
  std::swap(swapped.faces[0], swapped.faces[1]);
  EXPECT_EQ(of(room), of(moved));
  EXPECT_NE(of(room), of(renamed));
  EXPECT_NE(of(room), of(swapped));
  Scene bit = buildScene(room);
  bit.corners[5].y = std::nextafter(bit.corners[5].y, 100.0);
  EXPECT_NE(of(room), fingerprint(bit));
}

}  // namespace
}  // namespace viewpeel
