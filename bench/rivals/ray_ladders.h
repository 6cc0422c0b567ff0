// These functions make the rivals that trace rays. Where Embree is installed they are in ray_ladders.cpp, else
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

// A RayRival is one of the methods as verifyRivals runs it.
struct RayRival {
  std::string name;
  double work = 0;  // rays or samples that make an error well above rounding
  std::function<ExchangeMatrix(double work, uint64_t seed)> run;
};
std::vector<RayRival> makeRayRivals(const Scene& scene);

std::string describeRays();  // "Embree 3.13.5"; "none"

}  // namespace viewpeel::bench
