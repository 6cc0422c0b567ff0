// This file solves scenes without a matrix: docs/solve.md, eq. (1) to (6) and (14).
#include <viewpeel/matrix_free.h>

#include <cmath>

#include <fmt/format.h>

#include "solve/check_enclosure.h"
#include "solve/peeled_bands.h"
#include "solve/peeled_grey.h"
#include "solve/ranked_products.h"
#include "solve/split_rows.h"
#include "stopwatch.h"
#include "threads.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr double kBytesOfPair = 80;  // counters, form factors with their errors, and the equations; an estimate
constexpr uint32_t kMostDirections = 1 << 16, kScarceRounds = 2;
// Errors of answers are taken to fall as N^-0.6 with N directions. The next N aims at this share of the tolerance.
constexpr double kExponent = 0.6, kMargin = 0.9, kLeastGrowth = 1.5, kMostGrowth = 16;

constexpr HeatTolerance kOfHeat{0.01, HeatTolerance::Of::relative}, kOfTemperatures{1, HeatTolerance::Of::temperature};

struct Stopped {
  bool is_interrupted;
};

class MatrixFreeSolver {
 public:
  MatrixFreeSolver(const Scene& scene, const MaterialTable& materials, const MatrixFreeRequest& request,
                   const MatrixFreeObserver& observer)
      : request_(request), observer_(observer), ids_(makeIds(scene, request.by, request.two_sided)) {
    std::vector<std::string> surface_names;
    for (const Surface& surface : scene.surfaces) surface_names.push_back(surface.name);
    enclosure_ = assignMaterials(materials, ids_, surface_names);
    found_.tolerance = request.tolerance.value_or(areAllFluxesGiven(enclosure_) ? kOfTemperatures : kOfHeat);
    requireTolerance(found_.tolerance, enclosure_);
    split_ = splitRows(scene, ids_, enclosure_);
    exchange_ = std::make_unique<PeeledExchange>(
        scene, split_.ids, split_.shares, request, materials.up,
        PeeledExchange::Watch{.stop = [this] { stopInTime(); },
                              .show = [this](uint64_t done, uint64_t all) { show(done, all); }});
    if (!request.ranks || request.ranks->size() == 1) return;
    crew_ = std::make_unique<Crew>(*request.ranks, fingerprint(scene),
                                   request.threads ? request.threads : threadCount(), [this] { stopInTime(); });
    shareProducts(*crew_, exchange_->products(), exchange_->lattice(), ids_, enclosure_);
  }

  MatrixFreeHeat solve() {
    try {
      for (uint64_t directions = request_.first_directions;;) {
        exchange_->draw(static_cast<uint32_t>(directions), found_.rounds++);
        if (const std::optional<uint32_t> row = findRowWithoutReference()) {
          if (found_.rounds > kScarceRounds || directions * 4 > kMostDirections)
            refuseWithoutReference(split_.ids.names[*row]);
          directions *= 4;
          continue;
        }
        takeRound(solveRound());
        if (found_.is_reached || directions >= kMostDirections) return found_;
        directions = nextDirections(directions);
      }
    } catch (const Stopped& stopped) {
      if (!has_round_)
        throw Error(ErrorCode::limit, fmt::format("{} before the first answers; let it run longer",
                                                  stopped.is_interrupted ? "the run was stopped" : "time was up"));
      found_.is_interrupted = stopped.is_interrupted;
      found_.seconds = secondsSince(start_);
      return found_;
    }
  }

 private:
  void stopInTime() const {
    if (observer_.should_stop && observer_.should_stop()) throw Stopped{true};
    if (request_.time_limit_s && secondsSince(start_) >= *request_.time_limit_s) throw Stopped{false};
  }

  void show(uint64_t done, uint64_t all) const {
    if (observer_.on_progress) observer_.on_progress(exchange_->productCount() + 1, done, all, reached_);
  }

  // Finds a row of given heat flux that exchanges, even through other rows, with nothing of a given temperature. A
  // vector is 1 for rows that are known to do so, and products with it find further ones.
  std::optional<uint32_t> findRowWithoutReference() {
    const Eigen::Index n = exchange_->closed().areas.size();
    requireMaterials(exchange_->closed(), enclosure_, ids_);
    Columns refers(n, 1);
    for (Eigen::Index i = 0; i < n; ++i)
      refers(i, 0) =
          split_.enclosure.materials[static_cast<size_t>(i)].temperature || exchange_->closed().environment[i] > 0 ? 1
                                                                                                                   : 0;
    for (double referring = refers.sum(); referring < double(n);) {
      const Columns products = exchange_->multiply(refers);
      for (Eigen::Index i = 0; i < n; ++i)
        if (products(i, 0) > 0) refers(i, 0) = 1;
      const double now = refers.sum();
      if (now == referring) break;
      referring = now;
    }
    for (Eigen::Index i = 0; i < n; ++i)
      if (refers(i, 0) == 0) return static_cast<uint32_t>(i);
    return std::nullopt;
  }

  HeatSolution solveRound() {
    const Enclosure& enclosure = split_.enclosure;
    if (exchange_->closed().is_open && enclosure.sky_and_ground) {
      EnvironmentParts& parts = split_.enclosure.environment_parts.emplace();
      for (const double share : exchange_->upShare()) parts.up_share.push_back({share, 0});
    }
    return enclosure.band_limits_um.empty() ? solvePeeledGrey(*exchange_, split_, request_.residual, guess_)
                                            : solvePeeledBands(*exchange_, split_, request_.residual, guess_);
  }

  void takeRound(HeatSolution solution) {
    has_round_ = true;
    found_.heat = std::move(solution);
    found_.replicates = kProductReplicateCount;
    found_.directions = exchange_->directionCount();
    found_.sweeps = exchange_->sweeps();
    found_.resolution = exchange_->resolution();
    // Equations are solved for all replicates at once, with some vectors for each, a number for each row and band.
    const uint64_t bands = split_.enclosure.band_limits_um.size() + 1;
    const uint64_t vectors = bands > 1 ? kVectorsOfBands * bands : kVectorsOfGrey;
    found_.memory_bytes =
        exchange_->memoryBytes() + vectors * kProductReplicateCount * sizeof(double) * split_.ids.count();
    found_.seconds = secondsSince(start_);
    reached_ = largestHeatError(found_.heat, found_.tolerance.of);
    found_.is_reached = reached_ <= found_.tolerance.standard_error;
  }

  uint64_t nextDirections(uint64_t directions) const {
    const double excess = reached_ / (kMargin * found_.tolerance.standard_error);
    const double growth = std::clamp(std::pow(excess, 1 / kExponent), kLeastGrowth, kMostGrowth);
    return std::min<uint64_t>(static_cast<uint64_t>(std::ceil(double(directions) * growth)), kMostDirections);
  }

  const MatrixFreeRequest& request_;
  const MatrixFreeObserver& observer_;
  const Clock::time_point start_ = Clock::now();
  Ids ids_;                     // of the answers
  Enclosure enclosure_;         // of ids_
  SplitRows split_;             // of which the equations are
  std::unique_ptr<Crew> crew_;  // of several ranks
  std::unique_ptr<PeeledExchange> exchange_;
  Columns guess_;
  MatrixFreeHeat found_;
  bool has_round_ = false;
  double reached_ = INFINITY;
};

}  // namespace

double matrixBytes(uint64_t rows) { return kBytesOfPair * double(rows) * (double(rows) + 1) / 2; }

MatrixFreeHeat solveMatrixFree(const Scene& scene, const MaterialTable& materials, const MatrixFreeRequest& request,
                               const MatrixFreeObserver& observer) {
  return MatrixFreeSolver(scene, materials, request, observer).solve();
}

}  // namespace viewpeel
