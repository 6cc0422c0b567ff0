// Reads View3D's input, .vs3: vertices and surfaces (F 3), or surfaces placed by azimuth and tilt (F 3a).
//   Source: G. N. Walton, View3D user manual (NIST, public domain); View3D 4.0, getdat.c.
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// The control line; every value has View3D's default.
struct Vs3Control {
  double eps = 1e-4;
  uint32_t out = 0;               // 0 text, 1 binary, 2 sparse
  bool is_closed = false;         // encl
  bool has_emissivities = false;  // emit: Hottel's script-F in place of form factors
  uint32_t row = 0, column = 0;   // 0: all
  uint32_t list = 0;
  double largest_distance = std::numeric_limits<double>::infinity();  // maxD
};

// A Vs3Surface is a line S, M, N or O of the file.
struct Vs3Surface {
  char kind = 'S';
  std::vector<glm::dvec3> corners;     // counter-clockwise from the active side
  uint32_t base = 0, merged_into = 0;  // numbers from 1; 0: none
  double emissivity = 0.9;             // clamped to 0.001 .. 0.999
  std::string name;
  uint32_t line = 0;

  bool hasRow() const { return (kind == 'S' || kind == 'M') && merged_into == 0; }
};

struct Vs3File {
  std::string file, title;
  Vs3Control control;
  std::vector<Vs3Surface> surfaces;  // number k is surfaces[k - 1]
  std::vector<std::string> warnings;
};

// Reads a file.    Throws: Error bad_input naming file and line.
Vs3File parseVs3(const std::filesystem::path& file);

struct Vs3Scene {
  InputScene input;
  std::vector<uint32_t> surface_of;  // of each surface of the file: index into InputScene::surface_names
};

// Makes the scene of a file. Subsurfaces and null surfaces are cut out of their bases, and merged surfaces become one.
//   In: merges: false keeps surfaces apart that the file merges
//   Out: a surface for each with a row, in the order of their numbers, then those that only block (O and N). A null
//     surface blocks in the place of its base. A mask is face to face with its base. Names that are not distinct get
//     their numbers: "wall#8".
//   Throws: Error bad_input, naming the line, where a subsurface does not lie in its base.    Cost: O(surfaces).
Vs3Scene makeScene(const Vs3File& file, bool merges = true);

}  // namespace viewpeel
