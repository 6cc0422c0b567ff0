// EnvironmentRays casts rays from single rows. Common directions say little of a row that few of their lines meet, such
// as a small triangle among large ones; rays of its own say more.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "rays/ray_engine.h"
#include "scene/sight.h"
#include <viewpeel/ids.h>

namespace viewpeel {

// Quick rays are those of a RayEngine, in single precision: some 0.15 us a ray in place of 2 us. They may err by 2^-12
// at an edge (ray_engine.h). The least tolerance for them, a standard error, is four times as large.
inline constexpr double kLeastQuickTolerance = 0x1p-10;
// Returns whether the scene suits quick rays, and the tolerance is large enough for them.
bool hasQuickRays(const Scene& scene, double tolerance);

class EnvironmentRays {
 public:
  // In: up: of any length above 0; tolerance: as hasQuickRays() takes it; threads: at least 1; stop: is called often,
  //   and ends cast() by an exception    Keeps references to the scene and to ids.    Cost: O(polygons log polygons).
  EnvironmentRays(const Scene& scene, const Ids& ids, const glm::dvec3& up, uint64_t seed, double tolerance,
                  size_t threads, std::function<void()> stop);

  // RowRays say which rays a row gets in each replicate, and what they find.
  struct RowRays {
    struct Shares {
      double up = 0, down = 0;
    };
    uint32_t row = 0;
    uint32_t rays = 0;               // about so many; after cast(): rays of equal weight that would say as much
    double rays_cast = 0;            // Out: in a replicate
    std::vector<Shares> replicates;  // Out: shares that leave the scene above and below the horizon
  };
  // Casts rays from rows: starts uniform over the row, directions of the cosine law. Rows that an exception from stop()
  // leaves out have no replicates.
  //   Method: Sobol' points. Quick rays take points of four dimensions, scrambled for each polygon and replicate. Each
  //     polygon of a row has rays in proportion to its area, and at least RayEngine::kLeastRays. Other rays take points
  //     of five dimensions, one of which chooses the polygon. These points are shifted modulo 1, for each row and
  //     replicate apart (Cranley and Patterson 1976).
  //   Error: unbiased, but for the quick rays' error near edges    Cost: O(log polygons) a ray.
  void cast(std::vector<RowRays>& rows, uint32_t replicates);

 private:
  static constexpr uint32_t kDimensions = 5;

  void castQuickly(std::span<RowRays> rows, uint32_t replicates);
  RowRays::Shares castFrom(uint32_t row, uint32_t rays, uint32_t replicate) const;
  void preparePoints(uint32_t rays);

  const Scene& scene_;
  const Ids& ids_;
  glm::dvec3 up_;
  uint64_t seed_;
  size_t threads_;
  std::function<void()> stop_;
  std::vector<std::vector<uint32_t>> polygons_;  // of each row
  std::unique_ptr<RayEngine> engine_;            // counts by face; null where rays are not quick
  Ids face_ids_;                                 // of the engine
  std::vector<uint32_t> row_of_face_;
  std::optional<Sight> sight_;                  // in the engine's place, with the two below
  std::vector<std::vector<double>> area_sums_;  // of each row, cumulative over its polygons
  std::vector<std::array<double, kDimensions>> points_;
};

}  // namespace viewpeel
