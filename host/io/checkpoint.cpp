#include "io/checkpoint.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "io/hdf5_input.h"
#include "io/hdf5_output.h"
#include "io/sum_columns.h"
#include "io/write_file.h"
#include "sums/pair_walk.h"

namespace viewpeel {
namespace {

// Returns whether all of `replicates` are among the replicates that are held.
bool holdsAll(const std::vector<ReplicateRange>& held, const std::vector<ReplicateRange>& replicates) {
  return std::ranges::all_of(replicates, [&](const ReplicateRange& range) {
    return std::ranges::any_of(
        held, [&](const ReplicateRange& of) { return of.first <= range.first && range.end <= of.end; });
  });
}

constexpr uint64_t kFormat = 10;  // version of the file's layout; raise it when the columns below change

}  // namespace

std::optional<std::string> findSetting(const Settings& settings, const std::string& name) {
  const auto at =
      std::ranges::find(settings, name, [](const auto& setting) -> const std::string& { return setting.first; });
  if (at == settings.end()) return {};
  return at->second;
}

void writeCheckpoint(const Settings& settings, const RunSums& sums, const std::filesystem::path& file, FileLock* lock) {
  Hdf5Output out;
  out.write("format", std::vector<uint64_t>{kFormat});
  writeColumn<std::string>(out, "settings/names", settings, [](const auto& setting) { return setting.first; });
  writeColumn<std::string>(out, "settings/values", settings, [](const auto& setting) { return setting.second; });
  writeColumn<uint64_t>(out, "replicates/first", sums.replicates,
                        [](const ReplicateRange& range) { return range.first; });
  writeColumn<uint64_t>(out, "replicates/end", sums.replicates, [](const ReplicateRange& range) { return range.end; });
  out.write("directions", std::vector<uint64_t>{sums.directions});
  out.write("measure_area", std::vector<double>{sums.measure_area});
  writeReplicateSums(out, "by_id", sums.by_id);
  writeReplicateSums(out, "by_surface", sums.by_surface);
  writePriorSums(out, sums);
  writeLineSums(out, sums);
  if (!sums.rays.empty()) out.write("rays", sums.rays);
  if (!sums.line_steps.empty()) out.write("line_steps", sums.line_steps);
  writeFile(
      file, [&](std::ostream& stream) { out.finish(stream); }, lock);
}

Checkpoint readCheckpoint(const std::filesystem::path& file) {
  Hdf5Input in(file);
  const auto format = readOne<uint64_t>(in, "format");
  if (format != kFormat)
    throw Error(ErrorCode::bad_input, fmt::format("{}: a checkpoint of format {}, not {}; go on with the viewpeel that "
                                                  "wrote it, or start afresh with another file",
                                                  file.string(), format, kFormat));
  Settings settings;
  for (const std::string& name : in.read<std::string>("settings/names"))
    settings.push_back({name == "--closed-forms" ? "--unoccluded" : name, {}});  // the option's name before 0.3
  readColumn<std::string>(in, "settings/values", settings,
                          [](auto& setting, const std::string& value) { setting.second = value; });
  std::vector<ReplicateRange> replicates;
  for (uint64_t first : in.read<uint64_t>("replicates/first")) replicates.push_back({first, 0});
  readColumn<uint64_t>(in, "replicates/end", replicates, [](ReplicateRange& range, uint64_t end) { range.end = end; });
  const auto directions = readOne<uint64_t>(in, "directions");
  const auto measure_area = readOne<double>(in, "measure_area");
  ReplicateSums by_id = readReplicateSums(in, "by_id"), by_surface = readReplicateSums(in, "by_surface");
  for (const ReplicateSums* sums : {&by_id, &by_surface})
    if (std::ranges::any_of(sums->ids().surface, [&](uint32_t surface) { return surface >= by_surface.ids().count(); }))
      in.refuse("its ids are of surfaces that it does not have");
  std::optional<PriorSums> prior_sums = readPriorSums(in, by_id.ids(), by_surface.ids());
  std::optional<LineSums> lines = readLineSums(in, by_id.ids());
  if (lines && lines->leastFormFactor() > 0 && haveSharedKey(lines->pairs(), by_id.pairs()))
    in.refuse("a pair that has lines was counted by common directions, too");
  const bool has_rays = findSetting(settings, "--rays").has_value();
  Checkpoint checkpoint{std::move(settings),
                        {std::move(by_id), std::move(by_surface), std::move(replicates), directions, measure_area,
                         std::move(prior_sums), std::move(lines)}};
  if (has_rays) {
    std::vector<uint32_t> rays = in.read<uint32_t>("rays", checkpoint.sums.by_id.ids().count());
    if (std::ranges::any_of(rays, [](uint32_t of_face) { return of_face == 0; })) in.refuse("its 'rays' have a 0");
    checkpoint.sums.countRays(std::move(rays));
  }
  if (in.has("line_steps")) {
    std::vector<double> counts = in.read<double>("line_steps", checkpoint.sums.by_id.ids().count());
    if (std::ranges::any_of(counts, [](double count) { return !(count >= 1); }))
      in.refuse("its 'line_steps' are below 1");
    checkpoint.sums.setLineSteps(std::move(counts));
  }
  if (!checkpoint.sums.isWhole()) in.refuse("its list of replicates does not agree with its sums");
  return checkpoint;
}

void requireSameSettings(const Settings& expected, const Settings& found, const std::filesystem::path& file) {
  const auto valueOf = [](const Settings& settings, const std::string& name) {
    return findSetting(settings, name).value_or("not set");
  };
  for (const Settings* settings : {&expected, &found})
    for (const auto& [name, ignored] : *settings)
      if (valueOf(expected, name) != valueOf(found, name))
        throw Error(
            ErrorCode::bad_usage,
            fmt::format(
                "{}: a checkpoint of another run: {} is '{}' there, '{}' here; ask for the same, or take another file",
                file.string(), name, valueOf(found, name), valueOf(expected, name)));
}

Checkpoint mergeCheckpoints(const std::vector<std::filesystem::path>& files) {
  Checkpoint merged = readCheckpoint(files.front());
  for (size_t k = 1; k < files.size(); ++k) {
    Checkpoint other = readCheckpoint(files[k]);
    requireSameSettings(merged.settings, other.settings, files[k]);
    const ReplicateRange shared = findShared(merged.sums.replicates, other.sums.replicates);
    if (holdsAll(merged.sums.replicates, other.sums.replicates)) continue;
    if (holdsAll(other.sums.replicates, merged.sums.replicates)) {
      merged = std::move(other);
      continue;
    }
    if (shared.first < shared.end)
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: an earlier file has its replicates {} to {}, too, but not all: the sums of one file "
                              "cannot be taken apart; leave out one of the two, and count the rest again",
                              files[k].string(), shared.first, shared.end - 1));
    if (other.sums.by_id.ids().areas != merged.sums.by_id.ids().areas ||
        other.sums.by_surface.ids().areas != merged.sums.by_surface.ids().areas ||
        other.sums.measure_area != merged.sums.measure_area)
      throw Error(ErrorCode::bad_usage, fmt::format("{}: areas are not those of {}, though the settings are the same; "
                                                    "were they made by one build of viewpeel?",
                                                    files[k].string(), files.front().string()));
    if (other.sums.prior_sums.has_value() != merged.sums.prior_sums.has_value() ||
        (merged.sums.prior_sums && !merged.sums.prior_sums->goesWith(*other.sums.prior_sums)))
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("{}: its unoccluded form factors have other visibilities than {}, though the settings are the "
                      "same; were they made by one build of viewpeel?",
                      files[k].string(), files.front().string()));
    if (other.sums.lines.has_value() != merged.sums.lines.has_value() ||
        (merged.sums.lines && !merged.sums.lines->goesWith(*other.sums.lines)) || other.sums.rays != merged.sums.rays ||
        other.sums.line_steps != merged.sums.line_steps)
      throw Error(ErrorCode::bad_usage, fmt::format("{}: pairs have other lines, or polygons other rays, than in {}, "
                                                    "for it had another goal; give all parts of a run the same goal "
                                                    "and --replicates",
                                                    files[k].string(), files.front().string()));
    if (merged.sums.prior_sums && !merged.sums.prior_sums->directsAs(*other.sums.prior_sums))
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: other pairs have directions of their own than in {}, for it had another goal; give "
                              "all parts of a run the same goal and --replicates",
                              files[k].string(), files.front().string()));
    merged.sums.add(other.sums);
  }
  return merged;
}

std::string describeReplicates(const std::vector<ReplicateRange>& replicates) {
  std::string text;
  for (const ReplicateRange& range : replicates)
    text += fmt::format("{}{} to {}", text.empty() ? "" : ", ", range.first, range.end - 1);
  return text;
}

}  // namespace viewpeel
