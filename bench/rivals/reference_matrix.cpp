#include "bench/rivals/reference_matrix.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "reference/closed_forms/contour_integral.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kReferenceSeed = 1u << 21;  // different from the seeds of all ladders

// A kept file starts with this header. Exchange areas follow, and then the exchange areas with environment and leak.
struct Header {
  uint64_t version = 2, fingerprint = 0, count = 0;
  double seconds = 0;
  MatrixError error;
  double largest_rest_error = 0;
};

std::vector<double> areasOf(const Scene& scene) {
  std::vector<double> areas;
  for (const Polygon& polygon : scene.polygons) areas.push_back(polygon.area);
  return areas;
}

bool readKept(const std::string& file, uint64_t scene_fingerprint, double seconds, ReferenceMatrix& reference) {
  std::ifstream in(file, std::ios::binary);
  Header header;
  if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  if (header.version != Header{}.version || header.fingerprint != scene_fingerprint || header.seconds < seconds ||
      header.count != reference.exchange.count())
    return false;
  reference.rest.resize(header.count);
  for (std::vector<double>* values : {&reference.exchange.values(), &reference.rest})
    if (!in.read(reinterpret_cast<char*>(values->data()), static_cast<std::streamsize>(8 * values->size())))
      return false;
  reference.error = header.error;
  reference.largest_rest_error = header.largest_rest_error;
  reference.seconds = header.seconds;
  return true;
}

void keep(const std::string& file, const std::string& directory, uint64_t scene_fingerprint, double seconds,
          const ReferenceMatrix& reference) {
  std::filesystem::create_directories(directory);
  std::ofstream out(file, std::ios::binary);
  const Header header{.fingerprint = scene_fingerprint,
                      .count = reference.exchange.count(),
                      .seconds = seconds,
                      .error = reference.error,
                      .largest_rest_error = reference.largest_rest_error};
  out.write(reinterpret_cast<const char*>(&header), sizeof header);
  for (const std::vector<double>* values : {&reference.exchange.values(), &reference.rest})
    out.write(reinterpret_cast<const char*>(values->data()), static_cast<std::streamsize>(8 * values->size()));
  if (!out.flush())
    throw Error(ErrorCode::output, fmt::format("{}: cannot be written; choose another --cache directory", file));
}

// Mean has the mean of runs and its standard error, value by value. By B. P. Welford's recurrence (1962) runs that do
// not differ have an error of exactly 0.
class Mean {
 public:
  explicit Mean(size_t count) : means_(count), squares_(count) {}
  void add(const std::vector<double>& values) {
    ++runs_;
    for (size_t k = 0; k < values.size(); ++k) {
      const double off = values[k] - means_[k];
      means_[k] += off / runs_;
      squares_[k] += off * (values[k] - means_[k]);
    }
  }
  double mean(size_t k) const { return means_[k]; }
  double standardError(size_t k) const { return std::sqrt(squares_[k] / (runs_ * (runs_ - 1))); }

 private:
  double runs_ = 0;
  std::vector<double> means_, squares_;
};

// Sets the reference to the mean of eight runs. Together they take effort.seconds, or each has the given amount.
void averageRuns(const Ladder& ladder, const Scene& scene, const ReferenceEffort& effort, ReferenceMatrix& reference) {
  constexpr uint32_t kRuns = 8;
  const std::vector<double> areas = areasOf(scene);
  const Runner runner = ladder.set_up();
  size_t rung = 0;
  for (; !effort.amount && rung + 1 < ladder.rungs.size(); ++rung) {
    const double took_s = runner.run(ladder.rungs[rung].amount, kReferenceSeed).time.seconds;
    if (took_s * ladder.rungs[rung + 1].cost / ladder.rungs[rung].cost > effort.seconds / kRuns) break;
  }
  const double amount = effort.amount.value_or(ladder.rungs[rung].amount);
  std::vector<double>& values = reference.exchange.values();
  Mean pairs(values.size()), rest(areas.size());
  for (uint32_t k = 0; k < kRuns; ++k) {
    const Outcome outcome = runner.run(amount, kReferenceSeed + 1 + k);
    pairs.add(outcome.exchange.values());
    rest.add(outcome.rest.empty() ? restOf(outcome.exchange, areas) : outcome.rest);
  }
  ErrorSums errors;
  size_t at = 0;
  for (size_t i = 0; i < areas.size(); ++i) {
    reference.rest.push_back(rest.mean(i));
    reference.largest_rest_error = std::max(reference.largest_rest_error, rest.standardError(i) / areas[i]);
    for (size_t j = i + 1; j < areas.size(); ++j, ++at) {
      values[at] = pairs.mean(at);
      errors.add(values[at], pairs.standardError(at), areas[i], areas[j]);
    }
  }
  reference.error = errors.over(static_cast<uint32_t>(areas.size()));
  if (reference.error.rms == 0)
    throw Error(ErrorCode::bad_usage, fmt::format("--reference-method {}: its runs do not differ, so that they do not "
                                                  "say how wrong they are; choose a method with seeds",
                                                  ladder.method));
}

}  // namespace

ReferenceMatrix referenceByClosedForms(const Scene& scene) {
  const auto count = static_cast<uint32_t>(scene.polygons.size());
  ReferenceMatrix reference{ExchangeMatrix(count), {}, {}, 0, 0, "closed forms"};
  std::vector<std::vector<glm::dvec3>> corners;
  for (const Polygon& p : scene.polygons)
    corners.emplace_back(scene.corners.begin() + p.first_corner,
                         scene.corners.begin() + p.first_corner + p.corner_count);
  ErrorSums sums;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; ++j) {
      reference.exchange.at(i, j) = scene.polygons[i].area * reference::formFactor(corners[i], corners[j]);
      sums.add(reference.exchange.at(i, j), reference::kContourError * scene.polygons[i].area, scene.polygons[i].area,
               scene.polygons[j].area);
    }
  reference.error = sums.over(count);
  reference.rest = restOf(reference.exchange, areasOf(scene));
  reference.largest_rest_error = count * reference::kContourError;
  return reference;
}

ReferenceMatrix referenceByLongRun(const Device& device, const Scene& scene, const std::string& name, double seconds,
                                   const std::string& directory) {
  const auto count = static_cast<uint32_t>(scene.polygons.size());
  const uint64_t print = fingerprint(scene);
  const std::string file = fmt::format("{}/{}-{:016x}.bin", directory, name, print);
  ReferenceMatrix reference{ExchangeMatrix(count), {}, {}, 0, seconds, {}};
  if (!readKept(file, print, seconds, reference)) {
    LongRun run = runLong(device, scene, seconds);
    reference.exchange = std::move(run.exchange);
    reference.rest = std::move(run.rest);
    reference.largest_rest_error = run.largest_rest_error;
    ErrorSums sums;
    const std::vector<double> areas = areasOf(scene);
    for (uint32_t i = 0; i < count; ++i)
      for (uint32_t j = i + 1; j < count; ++j)
        sums.add(reference.exchange.at(i, j), run.standard_errors.at(i, j), areas[i], areas[j]);
    reference.error = sums.over(count);
    keep(file, directory, print, seconds, reference);
  }
  reference.source = fmt::format("a run of viewpeel for {:.0f} s with unoccluded form factors", reference.seconds);
  return reference;
}

ReferenceMatrix referenceByMethod(const Ladder& ladder, const Scene& scene, const std::string& name,
                                  const ReferenceEffort& effort, const std::string& directory) {
  const uint64_t print = fingerprint(scene);
  const std::string amount = effort.amount ? fmt::format("{}={:g}", ladder.amount_name, *effort.amount) : "";
  const std::string file = fmt::format("{}/{}-{:016x}-{}{}.bin", directory, name, print, ladder.method, amount);
  ReferenceMatrix reference{
      ExchangeMatrix(static_cast<uint32_t>(scene.polygons.size())), {}, {}, 0, effort.seconds, {}};
  if (!readKept(file, print, effort.amount ? 0 : effort.seconds, reference)) {
    averageRuns(ladder, scene, effort, reference);
    keep(file, directory, print, effort.seconds, reference);
  }
  reference.source = fmt::format("eight runs of {} {}", ladder.method,
                                 effort.amount ? "with " + amount : fmt::format("within {:.0f} s", reference.seconds));
  return reference;
}

}  // namespace viewpeel::bench
