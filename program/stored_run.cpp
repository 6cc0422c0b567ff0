#include "program/stored_run.h"

#include <fmt/format.h>

#include "program/warnings.h"
#include <viewpeel/error.h>
#include "estimator/face_exchanges.h"
#include "run/settings.h"
#include "scene/read_groups.h"

namespace viewpeel::program {

// A LoadedScene gives the unoccluded form factors of pairs, which checkpoints do not store.
struct StoredRun::LoadedScene {
  Scene scene;
  Ids face_ids;
  FaceExchanges exchanges;

  LoadedScene(const std::vector<std::string>& files, const std::string& groups, const SceneOptions& options,
              bool two_sided)
      : scene(loadGroupedScene({files.begin(), files.end()}, groups, options)),
        face_ids(makeIds(scene, By::polygon, two_sided)),
        exchanges(nullptr, scene, face_ids) {}
};

StoredRun::StoredRun(const std::vector<std::string>& checkpoints, const std::vector<std::string>& scene,
                     const std::string& groups)
    : first_file_(checkpoints.front()), merged_(mergeCheckpoints({checkpoints.begin(), checkpoints.end()})) {
  if (!scene.empty()) {
    of_ = std::make_unique<LoadedScene>(scene, groups, sceneOptionsOf(merged_.settings),
                                        findSetting(merged_.settings, "--two-sided") == "yes");
    const std::string computed = findSetting(merged_.settings, "scene").value_or("");
    if (identityOf(of_->scene) != computed)
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: another scene than that of {}: {}, not {}; give the scene that was computed",
                              of_->scene.file, first_file_, identityOf(of_->scene), computed));
  }
  is_sparse_ = merged_.sums.prior_sums && merged_.sums.prior_sums->by() == By::polygon &&
               !merged_.sums.prior_sums->prior().has_all_pairs;
  if (is_sparse_ && !of_)
    warn(
        "a checkpoint does not keep the unoccluded form factors of all pairs: pairs that few lines met have larger "
        "errors here, and pairs that no line met are missing; give the scene by --scene FILE");
  if (is_sparse_ && of_) of_->exchanges.learn(merged_.sums);
}

StoredRun::~StoredRun() = default;

const Scene* StoredRun::scene() const { return of_ ? &of_->scene : nullptr; }

void StoredRun::requireErrors() const {
  if (merged_.sums.replicateCount() < 2)
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: holds 1 replicate, a standard error needs 2; go on with it, or merge it with others",
                            first_file_));
}

Estimate StoredRun::estimate() {
  return makeEstimate(merged_.sums, EstimateOptions{}.relative_floor,
                      is_sparse_ && of_ ? of_->exchanges.rows() : ExchangeRow{});
}

}  // namespace viewpeel::program
