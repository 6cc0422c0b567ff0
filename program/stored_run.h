// A StoredRun is a run read from checkpoints, with its scene if the user names the scene's files.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "estimator/estimate.h"
#include "io/checkpoint.h"

namespace viewpeel::program {

class StoredRun {
 public:
  // Reads and adds up checkpoints.
  //   In: scene: files of the scene; empty if it is not available; groups: names of its faces, as for --groups
  //   Throws: as mergeCheckpoints and loadScene; Error bad_usage where the checkpoints are of another scene.
  StoredRun(const std::vector<std::string>& checkpoints, const std::vector<std::string>& scene,
            const std::string& groups = "");
  ~StoredRun();

  const Checkpoint& merged() const { return merged_; }
  // Returns the scene; nullptr if it is not available.
  const Scene* scene() const;
  // Returns the form factors, over all replicates.
  Estimate estimate();
  // Refuses a run of one replicate, for it has no standard errors.    Throws: Error bad_usage.
  void requireErrors() const;

 private:
  struct LoadedScene;

  std::string first_file_;
  Checkpoint merged_;
  std::unique_ptr<LoadedScene> of_;
  bool is_sparse_ = false;
};

}  // namespace viewpeel::program
