// Plans a city: plots between streets, buildings in parts under roofs, trees. Lengths are metres.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "scenes/plan_polygon.h"
#include "scenes/random.h"

namespace viewpeel::bench::city_plan {

using Side = std::vector<glm::dvec2>;  // from a corner to the next, both included
using Sides = std::vector<Side>;       // all around

struct Box {
  PlanPolygon outline;
  double low, high;
};

struct Tree {
  size_t plot;
  Box crown;          // a hedge is one that stands on the pavement
  PlanPolygon trunk;  // none of a hedge
};

struct Wall {
  Side side;
  std::vector<double> levels;
};

struct Part {  // of a building, under one roof
  std::vector<Wall> walls;
  PlanPolygon eaves;
  double height;  // of the eaves above the sea
  double apex;    // of a tent above its eaves; 0: a flat roof
  std::vector<Box> boxes;
};

struct Building {
  PlanPolygon footprint;
  std::vector<Part> parts;
};

struct CityPlan {
  PlanPolygon rim;
  std::vector<PlanPolygon> plots;
  std::vector<double> pavements;    // heights, by plot
  std::vector<Building> buildings;  // by plot; parks have no parts
  std::vector<Tree> trees;
  std::vector<double> heights;
};

// Rounds coordinates to single precision.
double rounded(double x);
glm::dvec2 rounded(glm::dvec2 p);
PlanPolygon rounded(PlanPolygon polygon);

// Returns the sides of a polygon, cut into columns of walls or whole.
Sides makeSides(const PlanPolygon& corners, bool in_columns);

// Lays out streets, plots and buildings: about `cells` plots.
void layOut(CityPlan& plan, uint32_t cells, SceneRandom& random);

// Plants trees and hedges where there is room for them, at most so many.
void plant(CityPlan& plan, size_t most, SceneRandom& random);

}  // namespace viewpeel::bench::city_plan
