#include <viewpeel/row_blocks.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "directions/sampler.h"
#include "engines/engine_factory.h"
#include "engines/lattice.h"
#include "estimator/plan.h"
#include "io/hdf5_output.h"
#include "io/hdf5_frame.h"
#include "io/write_file.h"
#include "run/ranked_rows.h"
#include "run/settings.h"
#include "run/setup.h"
#include "run/summaries.h"
#include "interrupted.h"
#include "stopwatch.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr uint32_t kMostBlocks = 1'000'000;
constexpr double kMostCounts = 3e7;  // of a rank in a planned replicate; 24 bytes each

void refuseBlocks(const std::string& what) { throw Error(ErrorCode::bad_usage, "--row-blocks: " + what); }

void requireKind(const RowBlocksRequest& blocks) {
  const Request& request = blocks.request;
  const auto* amount = std::get_if<FixedAmount>(&request.goal);
  if (!amount && !std::holds_alternative<Tolerance>(request.goal) && !std::holds_alternative<Relative>(request.goal))
    refuseBlocks("gives estimates; leave out --epsilon, --delta and --seconds, or give --directions or --tolerance");
  if (amount ? amount->finest : request.amount.finest)
    refuseBlocks("has no windows for small polygons; leave out --finest");
  if (request.amount.is_exact) refuseBlocks("has no parts; leave out --part");
  if (request.time_limit_s) refuseBlocks("has no time limit; leave out --seconds");
  if (!request.question.isEverything()) refuseBlocks("is for the whole matrix; leave out --from, --pair and --blocker");
  if (request.unoccluded.value_or(false) || request.pair_lines.value_or(false) || request.promise.value_or(false))
    refuseBlocks("takes common directions alone; leave out --unoccluded, --pair-lines and --promise");
  if (request.balance) refuseBlocks("cannot balance a matrix that no process holds; leave out --balance");
  if (request.engine == EngineKind::exact) refuseBlocks("takes an engine that counts; leave out --engine exact");
  if (blocks.block_count < 1 || blocks.block_count > kMostBlocks)
    refuseBlocks(fmt::format("{} is not a number of blocks from 1 to {}", blocks.block_count, kMostBlocks));
  if (!(blocks.drop_below >= 0 && blocks.drop_below < 1))
    refuseBlocks(fmt::format("{} is not a form factor from 0 to 1 below which pairs are left out", blocks.drop_below));
  if (blocks.output.extension() != ".h5")
    refuseBlocks("writes a .h5, block by block; give -o NAME.h5 and no other output");
}

Request settled(Request request) {
  request.unoccluded = false;
  request.pair_lines = false;
  return request;
}

class RowBlocksRun {
 public:
  RowBlocksRun(const Scene& scene, const RowBlocksRequest& request, const Observer& observer)
      : scene_(scene),
        request_(request),
        observer_(observer),
        setup_(
            scene, settled(request.request), [this](uint64_t directions) { show(directions); }, [this] { stop(); }),
        lattice_(setup_.lattices().lattice) {
    if (setup_.resolution()) lattice_.resolution = setup_.resolution();
    units_.relative_floor = setup_.estimate().relative_floor;
    units_.drop_below = request_.drop_below;
  }

  RowBlocksSummary run() {
    try {
      plan();
      count();
      write();
    } catch (const Interrupted&) {
      summary_.interrupted = true;
    }
    summary_.seconds = secondsSince(start_);
    return summary_;
  }

 private:
  void stop() const {
    if (observer_.should_stop && observer_.should_stop()) throw Interrupted{};
  }
  void show(uint64_t directions) {
    stop();
    progress_.phase = engine_ ? Progress::Phase::counting : Progress::Phase::planning;
    progress_.directions = directions, progress_.directions_of_replicate = directions_;
    progress_.replicates = summary_.replicates;
    if (observer_.on_progress) observer_.on_progress(progress_);
  }

  // Sets directions and resolution, and makes the engine. All polygons share one lattice. Where pilots plan, the counts
  // of a replicate fit into memory.
  void plan() {
    directions_ = setup_.estimate().directions;
    if (setup_.plans()) planByPilots();
    engine_ = latticeEngines(setup_.engine(), setup_.device())(scene_, setup_.ids(), lattice_);
    units_.measure_area = engine_->unitArea() * scene_.scale * scene_.scale / directions_;
    units_.line = std::round(pointArea(lattice_.resolution) / engine_->unitArea());
    units_.is_scanline = lattice_.sampling == Sampling::scanline;
    summary_.resolution = lattice_.resolution;
  }
  void planByPilots() {
    EstimateOptions options = setup_.estimate();
    options.most_counts = kMostCounts * (setup_.crew() ? setup_.crew()->size() : 1);
    Lattices lattices = setup_.lattices();
    lattices.may_group = false;
    const Plan found = planEstimate(scene_, setup_.ids(), options, lattices);
    directions_ = found.directions, lattice_.resolution = found.finest;
  }

  void count() {
    rows_.emplace(setup_.crew(), *engine_, setup_.ids(), setup_.engine(), lattice_, request_.block_count,
                  request_.output);
    for (uint64_t wanted = setup_.estimate().replicates; summary_.replicates < wanted; wanted = wantedReplicates()) {
      while (summary_.replicates < wanted) addReplicate();
      measure();
    }
  }

  void addReplicate() {
    const Request& request = setup_.request();
    rows_->add(sampleDirections(setup_.estimate().sampler, directions_, request.seed,
                                request.first_replicate + summary_.replicates));
    ++summary_.replicates;
    summary_.directions += directions_;
    show(0);
  }

  // Measures all blocks, and puts their reports one after another into `found_`.
  void measure() {
    units_.count_area = units_.measure_area * double(summary_.directions) / double(summary_.replicates);
    const uint32_t ranks = setup_.crew() ? static_cast<uint32_t>(setup_.crew()->size()) : 1;
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    found_ = {}, summary_.entries = summary_.most_entries_of_block = 0;
    for (uint32_t first = 0; first < request_.block_count; first += ranks) {
      for (const BlockReport& report : rows_->measure(first, units_)) {
        const uint64_t entries = std::accumulate(report.entry_counts.begin(), report.entry_counts.end(), uint64_t(0));
        summary_.entries += entries;
        summary_.most_entries_of_block = std::max(summary_.most_entries_of_block, entries);
        append(found_.entry_counts, report.entry_counts), append(found_.outside, report.outside);
        append(found_.row_sums, report.row_sums), append(found_.dropped, report.dropped);
        found_.dropped_pairs += report.dropped_pairs;
        found_.largest_standard_error = std::max(found_.largest_standard_error, report.largest_standard_error);
        found_.largest_relative_error = std::max(found_.largest_relative_error, report.largest_relative_error);
      }
      stop();
    }
    progress_.largest_standard_error = summary_.largest_standard_error = found_.largest_standard_error;
  }

  // Returns how many replicates the goal takes, as the errors so far predict it, but at most twice as many as are done.
  uint64_t wantedReplicates() const {
    const std::optional<double> tolerance = setup_.estimate().tolerance, relative = setup_.estimate().relative;
    const double ratio = std::max(tolerance ? found_.largest_standard_error / *tolerance : 0.0,
                                  relative ? found_.largest_relative_error / *relative : 0.0);
    return static_cast<uint64_t>(std::ceil(double(summary_.replicates) * std::clamp(ratio * ratio, 0.0, 2.0)));
  }

  // Writes the frame of the file, which has the rows and where each begins, and the blocks.
  void write() {
    const Ids& ids = setup_.ids();
    const std::vector<uint32_t> rows = ids.rows();
    std::vector<int64_t> starts(ids.rowCount() + 1, 0);
    for (size_t id = 0; id < rows.size(); ++id) starts[rows[id] + 1] = static_cast<int64_t>(found_.entry_counts[id]);
    for (size_t row = 1; row < starts.size(); ++row) starts[row] += starts[row - 1];
    const FormFactors of_rows(ids, std::move(found_.outside), std::move(found_.row_sums));
    const DroppedSums dropped{request_.drop_below, std::move(found_.dropped), found_.dropped_pairs};
    summary_.closure = measureClosure(of_rows);
    summary_.environment_share = shareOf(of_rows, kEnvironment);
    summary_.leak_share = shareOf(of_rows, kLeak);
    summary_.dropped_pairs = dropped.pairs;
    for (uint32_t id = 0; id < dropped.sums.size(); ++id)
      if (dropped.sums[id].value > summary_.most_dropped)
        summary_.most_dropped = dropped.sums[id].value, summary_.most_dropped_row = ids.names[id];
    const OutputContent content{.form_factors = of_rows,
                                .scene = &scene_,
                                .parameters = parameters(),
                                .dropped = request_.drop_below > 0 ? &dropped : nullptr};
    writeFileByName(request_.output, [&](const std::string& name) {
      std::ofstream out(name, std::ios::binary);
      const std::map<std::string, uint64_t> places = writeHdf5Frame(content, starts, out);
      out.close();
      if (!out)
        throw Error(ErrorCode::output, fmt::format("{}: cannot write; choose another place", request_.output.string()));
      rows_->write(units_, starts, places, name);
      endFrame(name);
    });
  }

  // Returns the attributes of the file, as an ordinary run has them.
  std::vector<std::pair<std::string, std::string>> parameters() const {
    Settings settings = settingsOf(setup_);
    settings.insert(settings.end(), {{"--unoccluded", "off"},
                                     {"--directions", std::to_string(directions_)},
                                     {"--resolution", std::to_string(lattice_.resolution)},
                                     {"--finest", "0"}});
    Estimate estimate{FormFactors({}, {}, {}), FormFactors({}, {}, {})};
    estimate.replicates = summary_.replicates, estimate.directions = summary_.directions;
    estimate.largest_standard_error = summary_.largest_standard_error;
    auto parameters = parametersOf(settings, estimate);
    parameters.insert(parameters.end(), request_.parameters.begin(), request_.parameters.end());
    return parameters;
  }

  const Scene& scene_;
  const RowBlocksRequest& request_;
  const Observer& observer_;
  const Clock::time_point start_ = Clock::now();
  Setup setup_;
  LatticeOptions lattice_;
  std::unique_ptr<Engine> engine_;
  uint32_t directions_ = 0;  // of a replicate
  BlockUnits units_;
  std::optional<RankedRows> rows_;
  BlockReport found_;  // of all rows
  Progress progress_;
  RowBlocksSummary summary_;
};

}  // namespace

RowBlocksSummary computeRowBlocks(const Scene& scene, const RowBlocksRequest& request, const Observer& observer) {
  requireKind(request);
  checkRequest(settled(request.request));
  return RowBlocksRun(scene, request, observer).run();
}

}  // namespace viewpeel
