#pragma once
#include <vector>

#include "matrix/ids.h"
#include "matrix/pair_count.h"
#include "vulkan/commands.h"

namespace viewpeel {

// The scene as the shaders read it.
struct SceneBuffers {
  Buffer polygons;  // PolygonData[polygon_count]
  Buffer corners;   // dvec3[corner_count]
  uint32_t polygon_count, corner_count;

  SceneBuffers(const Device& device, const Scene& scene, const Ids& ids);
};

// Fraction bits of snapped coordinates: lattice coordinates stay within resolution / 2 + 1, and kSnapBits hold them.
//   Throws: Error bad_usage where the resolution is out of range.
int chooseFractionBits(int resolution);

// Dense counters of all pairs of ids, 32 bits each on the device, summed in 64 bits on the host.
class PairCounters {
 public:
  // Throws: Error limit where they need more than `budget_bytes` or than the device allows in one allocation.
  PairCounters(const Device& device, uint32_t id_count, uint64_t budget_bytes);

  VkDeviceAddress address() const { return counters_.address(); }
  uint32_t idCount() const { return id_count_; }

  // Empties everything.
  void start(Commands& commands);
  // Called before a submission that adds at most `most` to any one counter, less than 2^32: the device's counters are read and emptied before
  // one could overflow.
  void makeRoom(Commands& commands, uint64_t most);
  // Everything counted since start().
  PairCounts finish(Commands& commands);

 private:
  void clear(Commands& commands);
  void read(Commands& commands);

  uint32_t id_count_;
  uint64_t counter_count_;
  uint64_t most_in_counter_ = 0;  // bound on any device counter
  Buffer counters_, read_back_;
  std::vector<uint64_t> sums_;
};

}  // namespace viewpeel
