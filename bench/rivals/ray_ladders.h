// These functions make the rivals that trace rays. ray_ladders.cpp has them where Embree is installed; elsewhere
// without_embree.cpp makes none.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/rivals/methods.h"

namespace viewpeel::bench {

// Makes the ladders of ray shooting and of the double area integral, with random and Sobol' points, on all cores.
void addRayLadders(const Scene& scene, std::vector<Ladder>& ladders);

// A RayRival is one of these methods, for verifyRivals().
struct RayRival {
  std::string name;
  double work = 0;  // number of rays or samples at which the error is well above rounding
  std::function<ExchangeMatrix(double work, uint64_t seed)> run;
};
std::vector<RayRival> makeRayRivals(const Scene& scene);

std::string describeRays();  // "Embree 3.13.5", or "none"

}  // namespace viewpeel::bench
