// What `compute` and `plan` share: their options, and the scene, device and plan that these come to.
#pragma once
#include <memory>
#include <optional>

#include "program/checkpoint_keeper.h"
#include "program/options.h"
#include "estimator/directed_pairs.h"
#include "estimator/guarantee.h"
#include "estimator/plan.h"
#include "estimator/visible_share.h"

namespace viewpeel::program {

struct ProgramOptions {
  std::string scene;
  SceneOptions scene_options;
  std::vector<std::string> outputs;
  EngineKind engine = EngineKind::automatic;
  std::optional<Sampling> sampling;  // chosen where unset
  LatticeOptions lattice;
  bool two_sided = false;
  DeviceOptions device;
  EstimateOptions estimate;
  CheckpointOptions checkpoint;
  Question question;
  bool whole_sphere = false;  // a sampler was asked for by name
  bool plans = true;          // directions and, where 0, resolution
  int resolution = 0, finest = 0;
  std::optional<double> epsilon;  // guarantee mode
  double delta = 0.01, range = 0;
  uint32_t block = 0;
  Statistic statistic = Statistic::mean;
  bool closure = false;
  std::optional<bool> closed_forms;  // settled where unset
  bool closed_forms_by_default = false, closed_forms_possible = false;
  bool quiet = false, verbose = false, json = false;
};

// The options of both.
std::shared_ptr<ProgramOptions> addOptions(CLI::App* command);
// What follows from those given, once all are read.    Throws: Error bad_usage for those that contradict each other.
void settle(const CLI::App* command, ProgramOptions& options);

// What a run works on.
struct Session {
  ProgramOptions& options;
  const Scene scene;
  Ids ids;
  Ids face_ids;  // by polygon, whatever was asked for
  std::string sampler;  // in words
  std::optional<Device> device;  // of an engine that needs one

  // Prints warnings on stderr.    Throws: what reading the scene and finding a device throw; Error bad_usage.
  explicit Session(ProgramOptions& asked);
  bool hasWindows() const { return options.engine == EngineKind::compute || options.engine == EngineKind::host; }
  // Of what counts.
  std::string deviceName() const { return isExact() ? "none" : options.engine == EngineKind::host ? "processor" : device->description().name; }
  const Device* deviceOrNone() const { return device ? &*device : nullptr; }
  bool isExact() const { return options.engine == EngineKind::exact; }
  bool usesClosedForms() const { return *options.closed_forms; }
  bool talks() const { return !options.quiet && !options.json; }
  Lattices lattices() const;
  // Engines for pairs with directions of their own.
  MakePairEngine pairEngines() const;
  GuaranteeOptions guaranteeOptions() const;

  // As asked for, or planned; then without closed forms where counts would be too large for those that nobody asked for.    Throws: Error bad_usage where they were asked for.
  Plan plan() const;
  //   Throws: Error bad_usage where it would take longer than --seconds.
  GuaranteePlan planGuarantee() const;

  // Prints device and scene.
  void describe() const;
  // What a plan promises, and how to have the same run again; several lines.
  std::string describe(const Plan& plan) const;
  std::string describe(const GuaranteePlan& plan) const;
  // Of one that was asked for, not found out by pilots: how long it takes, from a few directions.
  std::string describeTime(const Plan& plan) const;
  std::string describe(const VisibleShares& known) const;

  // What decides about the counts of a run: a checkpoint is gone on with under the same settings only. Before it is planned, and then.
  //   Throws: Error bad_usage for runs that checkpoints cannot keep.
  Settings settings() const;
  Settings settings(const Plan& plan) const;
  Settings settings(const GuaranteePlan& plan) const;

 private:
  void chooseEngine();
};

}  // namespace viewpeel::program
