// How the exact path's time grows: every quadrilateral of a scene cut into k x k, one direction after another on one core.
// Out: CSV on stdout: polygons, edges of the arrangement (projected edges and their crossings), median and largest seconds per direction.
#include <algorithm>
#include <chrono>
#include <cstdio>

#include <glm/glm.hpp>

#include "directions/sampler.h"
#include "reference/exact_pair_areas.h"

namespace {

using namespace viewpeel;

Scene refine(const Scene& scene, int k) {
  InputScene input{scene.file, {"all"}, {}};
  for (const Polygon& polygon : scene.polygons) {
    const glm::dvec3* c = &scene.corners[polygon.first_corner];
    if (polygon.corner_count != 4) {
      input.faces.push_back({{c, c + polygon.corner_count}, 0, 0});
      continue;
    }
    const auto at = [&](int i, int j) {
      const double s = double(i) / k, t = double(j) / k;
      return (1 - s) * (1 - t) * c[0] + s * (1 - t) * c[1] + s * t * c[2] + (1 - s) * t * c[3];
    };
    for (int i = 0; i < k; ++i)
      for (int j = 0; j < k; ++j) input.faces.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, 0, 0});
  }
  return buildScene(input);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: exact_growth SCENE\n");
    return 2;
  }
  const Scene scene = loadScene(argv[1]);
  std::printf("polygons,arrangement_edges,median_seconds,largest_seconds\n");
  for (int k : {1, 2, 3, 4, 6}) {
    const Scene refined = refine(scene, k);
    std::vector<double> seconds;
    uint64_t edges = 0;
    for (const Direction& direction : sampleDirections(Sampler::iid, 5, 1, 0)) {
      const auto start = std::chrono::steady_clock::now();
      edges += reference::computePairAreas(refined, direction.u).edge_count / 5;
      seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(seconds.begin(), seconds.end());
    std::printf("%zu,%lu,%.3f,%.3f\n", refined.polygons.size(), static_cast<unsigned long>(edges), seconds[2], seconds[4]);
    std::fflush(stdout);
  }
  return 0;
}
