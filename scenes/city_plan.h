// These functions plan a city: plots between streets, buildings whose parts have roofs of their own, and trees. Lengths
// are in metres.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "scenes/plan_polygon.h"
#include "scenes/random.h"

namespace viewpeel::bench::city_plan {

using Side = std::vector<glm::dvec2>;  // points from one corner to the next, with both corners
using Sides = std::vector<Side>;       // all sides of a polygon, in order

struct Box {
  PlanPolygon outline;
  double low, high;
};

struct Tree {
  size_t plot;
  Box crown;          // the crown of a hedge stands on the pavement
  PlanPolygon trunk;  // empty for a hedge
};

struct Wall {
  Side side;
  std::vector<double> levels;
};

struct Part {  // a part of a building, under one roof
  std::vector<Wall> walls;
  PlanPolygon eaves;
  double height;  // height of the eaves above z = 0
  double apex;    // height of a tent roof above its eaves; 0: a flat roof
  std::vector<Box> boxes;
};

struct Building {
  PlanPolygon footprint;
  std::vector<Part> parts;
};

struct CityPlan {
  PlanPolygon rim;
  std::vector<PlanPolygon> plots;
  std::vector<double> pavements;    // height of the pavement of each plot
  std::vector<Building> buildings;  // building of each plot; a park has no parts
  std::vector<Tree> trees;
  std::vector<double> heights;
};

// Rounds coordinates to single precision.
double rounded(double x);
glm::dvec2 rounded(glm::dvec2 p);
PlanPolygon rounded(PlanPolygon polygon);

// Returns the sides of a polygon.    In: in_columns: whether a side is cut into the columns of a wall
Sides makeSides(const PlanPolygon& corners, bool in_columns);

// Lays out streets, plots and buildings: about `cells` plots.
void layOut(CityPlan& plan, uint32_t cells, SceneRandom& random);

// Plants up to `most` trees and hedges where there is room for them.
void plant(CityPlan& plan, size_t most, SceneRandom& random);

}  // namespace viewpeel::bench::city_plan
