#include "bench/rivals/ray_ladders.h"

namespace viewpeel::bench {

void addRayLadders(const Scene&, std::vector<Ladder>&) {}
std::vector<RayRival> makeRayRivals(const Scene&) { return {}; }
std::string describeRays() { return "none"; }

}  // namespace viewpeel::bench
