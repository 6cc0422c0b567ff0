// A StoredRun is what checkpoints hold of a run, with the scene that was computed where it is needed.
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
  //   In: scene: the file that was computed; empty where it is not at hand; groups: names of its faces, as of --groups
  //   Throws: as mergeCheckpoints and loadScene; Error bad_usage for another scene than the checkpoints'.
  StoredRun(const std::vector<std::string>& checkpoints, const std::string& scene, const std::string& groups = "");
  ~StoredRun();

  const Checkpoint& merged() const { return merged_; }
  // Returns the scene that was computed; nullptr where it is not at hand.
  const Scene* scene() const;
  // Returns the form factors of all replicates.
  Estimate estimate();
  // Refuses a run of one replicate, which has no standard errors.    Throws: Error bad_usage.
  void requireErrors() const;

 private:
  struct LoadedScene;

  std::string first_file_;
  Checkpoint merged_;
  std::unique_ptr<LoadedScene> of_;
  bool is_sparse_ = false;
};

}  // namespace viewpeel::program
