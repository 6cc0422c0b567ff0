// EmbreeScene holds a scene for Embree 3 and traces groups of rays through it: one by one, in packets, or in streams.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <embree3/rtcore.h>
#include <glm/glm.hpp>

#include <viewpeel/scene.h>

namespace viewpeel::bench {

enum class Trace { single, packets_of_8, streams };

constexpr uint32_t kRayGroup = 64;  // rays traced together: a stream, or 8 packets

struct Ray {
  glm::vec3 origin, direction;
  float near, far;
};

class EmbreeScene {
 public:
  // Builds the tree with RTC_BUILD_QUALITY_HIGH, of quads where all polygons have four corners, else of triangles.
  explicit EmbreeScene(const Scene& scene);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  const glm::vec3& normal(uint32_t polygon_index) const { return normals_[polygon_index]; }
  uint32_t polygonOf(uint32_t primitive) const { return polygon_of_primitive_[primitive]; }

  // Finds the first polygon on each ray.
  //   In: at most kRayGroup rays    Out: the polygon that each hits first, or UINT32_MAX
  void findFirst(Trace trace, RTCIntersectContext& context, std::span<const Ray> rays, std::span<uint32_t> hit) const;
  // Finds whether something blocks each ray. A filter in the context is called for every hit, with the index of the ray
  // as its id.
  void findBlocked(Trace trace, RTCIntersectContext& context, std::span<const Ray> rays, std::span<bool> blocked) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::vector<uint32_t> polygon_of_primitive_;
  std::vector<glm::vec3> normals_;  // by polygon index
};

inline uint32_t threadCount() { return std::max(1u, std::thread::hardware_concurrency()); }

template <class Run>
void runOnAllCores(Run run) {
  std::vector<std::thread> threads;
  for (uint32_t k = 1; k < threadCount(); ++k) threads.emplace_back(run, k);
  run(0u);
  for (std::thread& thread : threads) thread.join();
}

// Returns the version of Embree, as "3.13.5".
std::string embreeVersion();

}  // namespace viewpeel::bench
