// coincidentScenes() makes scenes with coincident faces, as users draw them: thin walls, and solids that touch. Each
// scene can also be made with a gap in place of every coincidence, so that no doubt is left which of the two is meant.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "scenes/named_scenes.h"

namespace viewpeel::test_scenes {

// Adds two faces back to back, `gap` apart, on either side of a parallelogram. The first face looks along a x b.
inline void addSheet(InputScene& scene, const std::string& name, glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b,
                     double gap) {
  const glm::dvec3 half = glm::normalize(glm::cross(a, b)) * (gap / 2);
  addFace(scene, name + "+", parallelogram(origin + half, a, b));
  addFace(scene, name + "-", parallelogram(origin - half, b, a));
}

inline void addSolid(InputScene& scene, const std::string& name, glm::dvec3 low, glm::dvec3 high) {
  addBox(scene, name, low, high, false, true);
}
inline void addRoom(InputScene& scene, const std::string& name, glm::dvec3 low, glm::dvec3 high) {
  addBox(scene, name, low, high, true, true);
}

struct CoincidentScene {
  std::string name;
  bool is_closed;
  // Only the gap decides the meaning of this scene: a gap of 0 is in doubt, and a negative gap has the other meaning.
  bool needs_gap;
  std::function<InputScene(double gap)> make;
};

// The function is long because each scene is written beside its name and its flags.
inline std::vector<CoincidentScene> coincidentScenes() {
  const auto named = [](const char* name) { return InputScene{name, {}, {}}; };
  return {
      {"baffle in a room", true, false,
       [=](double gap) {
         InputScene s = named("baffle");
         addRoom(s, "room", {0, 0, 0}, {1, 1, 1});
         addSheet(s, "baffle", {0.25, 0.75, 0.25}, {0.5, 0, 0}, {0, 0, 0.5}, gap);
         return s;
       }},
      {"two rooms with one wall", true, false,
       [=](double gap) {
         InputScene s = named("rooms");
         addRoom(s, "left", {0, 0, 0}, {1 - gap / 2, 1, 1});
         addRoom(s, "right", {1 + gap / 2, 0, 0}, {2, 1, 1});
         return s;
       }},
      {"three rooms in a row", true, false,
       [=](double gap) {  // rays decide the walls of the middle room, through walls that are decided before
         InputScene s = named("row");
         for (int k = 0; k < 3; ++k)
           addRoom(s, std::string("room") + "abc" [k], { k + gap / 2, 0, 0 }, {k + 1 - gap / 2, 1, 1});
         return s;
       }},
      {"panel in space", false, true,
       [=](double gap) {
         InputScene s = named("panel");
         addSolid(s, "bus", {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
         addSheet(s, "panel", {0.7, -0.5, 0}, {2, 0, 0}, {0, 1, 0}, gap);
         return s;
       }},
      {"sheet alone", false, true,
       [=](double gap) {
         InputScene s = named("alone");
         addSheet(s, "sheet", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, gap);
         return s;
       }},
      {"box on a one-sided floor", false, false,
       [=](double gap) {
         InputScene s = named("floor");
         addFace(s, "floor", parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}));
         addSolid(s, "box", {-0.5, -0.5, gap}, {0.5, 0.5, 1});
         return s;
       }},
      {"box on a floor plate", false, false,
       [=](double gap) {
         InputScene s = named("plate");
         addSheet(s, "plate", {-2, -2, -gap / 2}, {4, 0, 0}, {0, 4, 0}, gap);
         addSolid(s, "box", {-0.5, -0.5, gap}, {0.5, 0.5, 1});
         return s;
       }},
      {"box on the floor of a room", true, false,
       [=](double gap) {
         InputScene s = named("box in a room");
         addRoom(s, "room", {-2, -2, 0}, {2, 2, 3});
         addSolid(s, "box", {-0.5, -0.3, gap}, {0.5, 0.6, 1});
         return s;
       }},
      {"box in a corner", true, false,
       [=](double gap) {
         InputScene s = named("corner");
         addRoom(s, "room", {0, 0, 0}, {2, 2, 2});
         addSolid(s, "box", {gap, gap, gap}, {0.6, 0.7, 0.8});
         return s;
       }},
      {"stacked boxes", true, false,
       [=](double gap) {
         InputScene s = named("stack");
         addRoom(s, "room", {-2, -2, -1}, {2, 2, 3});
         addSolid(s, "low", {-0.6, -0.6, -0.5}, {0.6, 0.6, 0.3});
         addSolid(s, "middle", {-0.4, -0.2, 0.3 + gap}, {0.9, 0.5, 0.8});
         addSolid(s, "high", {-0.4, -0.2, 0.8 + gap}, {0.9, 0.5, 1.2});
         return s;
       }},
      {"box against a partition", true, false,
       [=](double gap) {  // three coincident faces
         InputScene s = named("partition");
         addRoom(s, "room", {0, 0, 0}, {2, 2, 2});
         addSheet(s, "partition", {1, 0.3, 0.3}, {0, 1.2, 0}, {0, 0, 1.2}, gap);
         addSolid(s, "box", {1 + 1.5 * gap, 0.6, 0.7}, {1.5, 1.1, 1.2});
         return s;
       }},
      {"box that sticks out behind a partition", true, false,
       [=](double gap) {
         InputScene s = named("sticking out");
         addRoom(s, "room", {0, 0, 0}, {2, 2, 2});
         addSheet(s, "partition", {1, 0.3, 0.3}, {0, 0.8, 0}, {0, 0, 1.2}, gap);
         addSolid(s, "box", {1 + 1.5 * gap, 0.9, 0.7}, {1.5, 1.5, 1.2});
         return s;
       }},
      {"panel on a box", false, false,
       [=](double gap) {  // three coincident faces: the box's top looks up, the panel's back down, its front up
         InputScene s = named("radiator");
         addSolid(s, "box", {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
         addSheet(s, "panel", {-0.3, -0.2, 0.5 + 1.5 * gap}, {0.5, 0, 0}, {0, 0.4, 0}, gap);
         return s;
       }},
      {"panel on a sheet", true, true,
       [=](double gap) {  // the panel could lie on either side of the sheet; the later face of the file lies on top
         InputScene s = named("panel on a sheet");
         addRoom(s, "room", {0, 0, 0}, {1, 1, 1});
         addSheet(s, "sheet", {0.2, 0.2, 0.5}, {0.6, 0, 0}, {0, 0.6, 0}, gap);
         addSheet(s, "panel", {0.4, 0.3, 0.5 + 2 * gap}, {0.2, 0, 0}, {0, 0.3, 0}, gap);
         return s;
       }},
      {"pane in a hole", true, false,
       [=](double gap) {
         InputScene s = named("pane");
         addRoom(s, "room", {0, 0, 0}, {2, 1, 1});
         addSheet(s, "low", {1, 0, 0}, {0, 1, 0}, {0, 0, 0.3}, gap);
         addSheet(s, "high", {1, 0, 0.7}, {0, 1, 0}, {0, 0, 0.3}, gap);
         addSheet(s, "near", {1, 0, 0.3}, {0, 0.3, 0}, {0, 0, 0.4}, gap);
         addSheet(s, "far", {1, 0.7, 0.3}, {0, 0.3, 0}, {0, 0, 0.4}, gap);
         addSheet(s, "pane", {1, 0.3, 0.3}, {0, 0.4, 0}, {0, 0, 0.4}, gap);
         return s;
       }},
      {"boxes side by side", true, false,
       [=](double gap) {
         InputScene s = named("side by side");
         addRoom(s, "room", {-2, -2, -1}, {2, 2, 3});
         addSolid(s, "a", {-1, -0.5, 0}, {-gap / 2, 0.5, 1});
         addSolid(s, "b", {gap / 2, -0.2, 0.3}, {1, 0.9, 1.4});
         return s;
       }},
  };
}

// Returns the scene turned about two axes and moved, so that no coordinate stays a round number.
inline InputScene turnedAndMoved(InputScene scene) {
  const auto turn = [](glm::dvec3 x) {
    const double a = 0.7, b = 1.9;
    x = {std::cos(a) * x.x - std::sin(a) * x.y, std::sin(a) * x.x + std::cos(a) * x.y, x.z};
    return glm::dvec3(x.x, std::cos(b) * x.y - std::sin(b) * x.z, std::sin(b) * x.y + std::cos(b) * x.z);
  };
  for (InputFace& face : scene.faces)
    for (glm::dvec3& corner : face.corners) corner = turn(corner) + glm::dvec3(0.37, -1.1, 0.59);
  return scene;
}

inline InputScene roundedToSingle(InputScene scene) {
  for (InputFace& face : scene.faces)
    for (glm::dvec3& corner : face.corners)
      for (int axis = 0; axis < 3; ++axis)
        corner[axis] = double(float(corner[axis]));  // GCC 12 at -O3 leaves dvec3(vec3()) out
  return scene;
}

}  // namespace viewpeel::test_scenes
