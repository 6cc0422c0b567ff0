// alikeScenes() makes scenes in which faces overlap in one plane and look the same way. Each scene can also be made
// with the hidden parts cut away, so that no doubt is left which face a line must hit.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include <viewpeel/engine.h>
#include "scenes/coincident_scenes.h"

namespace viewpeel::test_scenes {

// Returns the opposite direction with the same lines. The lattice points of each row are mirrored.
inline Direction reversed(Direction direction) {
  direction.u = -direction.u;
  direction.x_axis = -direction.x_axis;
  direction.offset.x = 1 - direction.offset.x;
  return direction;
}

struct AlikeScene {
  std::string name;
  std::function<InputScene(bool cut)> make;  // cut: leaves out the parts that another face hides
};

// Adds a tile to the floor z = 0: from x = low to x = high, and from y = 0 to y = 1.
inline void addTile(InputScene& scene, const std::string& name, double low, double high) {
  addFace(scene, name, parallelogram({low, 0, 0}, {high - low, 0, 0}, {0, 1, 0}));
}

// Adds the walls and the ceiling of a room that is 1 deep and 1 high. It has no floor.
inline void addWalls(InputScene& scene, double length) {
  InputScene room{"", {}, {}};
  addRoom(room, "room", {0, 0, 0}, {length, 1, 1});
  for (const InputFace& face : room.faces)
    if (room.surface_names[face.surface] != "roomz0") addFace(scene, room.surface_names[face.surface], face.corners);
}

inline std::vector<AlikeScene> alikeScenes() {
  const auto named = [](const char* name) { return InputScene{name, {}, {}}; };
  return {
      {"two triangles",
       [=](bool cut) {
         InputScene s = named("two triangles");
         addFace(s, "left", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
         addFace(s, "right", {{cut ? 0.5 : 0, cut ? 0.5 : 0, 0}, {1, 0, 0}, {1, 1, 0}});
         return s;
       }},
      {"floor of two tiles",
       [=](bool cut) {
         InputScene s = named("two tiles");
         addWalls(s, 1);
         addTile(s, "first", 0, 0.6);
         addTile(s, "second", cut ? 0.6 : 0.4, 1);
         return s;
       }},
      {"floor drawn first",
       [=](bool cut) {
         InputScene s = named("drawn first");
         addTile(s, "first", 0, 0.6);
         addTile(s, "second", cut ? 0.6 : 0.4, 1);
         addWalls(s, 1);
         return s;
       }},
      {"ceiling of two tiles",  // the largest polygon defines the plane: the tiles look against its normal
       [=](bool cut) {
         InputScene s = named("ceiling");
         addTile(s, "first", 0, 0.6);
         addTile(s, "second", cut ? 0.6 : 0.4, 1);
         for (InputFace& face : s.faces) std::reverse(face.corners.begin(), face.corners.end());
         addFace(s, "roof", parallelogram({-1, -1, 0}, {3, 0, 0}, {0, 3, 0}));
         return s;
       }},
      {"square and its halves",
       [=](bool cut) {
         InputScene s = named("halves");
         addWalls(s, 1);
         addTile(s, "whole", 0, 1);
         if (cut) return s;
         addFace(s, "low half", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
         addFace(s, "high half", {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}});
         return s;
       }},
      {"row of twelve tiles",  // more than there are tie ranks; of two neighbours the first, third, ... counts
       [=](bool cut) {
         InputScene s = named("row of tiles");
         addWalls(s, 12);
         for (int k = 0; k < 12; ++k) {
           const double over = cut && k % 2 ? -0.125 : 0.125;
           addTile(s, std::string("tile ") + "abcdefghijkl"[k], k > 0 ? k - over : 0, k < 11 ? k + 1 + over : 12);
         }
         return s;
       }},
      {"box on two tiles",
       [=](bool cut) {
         InputScene s = named("box on tiles");
         addWalls(s, 1);
         addTile(s, "first", 0, 0.6);
         addTile(s, "second", cut ? 0.6 : 0.4, 1);
         addSolid(s, "box", {0.3, 0.3, 0}, {0.8, 0.7, 0.4});
         return s;
       }},
  };
}

}  // namespace viewpeel::test_scenes
