// parseVs3() reads View3D's input, .vs3: vertices and surfaces (F 3), or surfaces placed by azimuth and tilt (F 3a).
//   Source: G. N. Walton, View3D user manual (NIST, public domain); View3D 4.0, getdat.c.
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A Vs3Control holds the values of the control line C. Values that the line does not give have View3D's defaults.
struct Vs3Control {
  double eps = 1e-4;
  uint32_t out = 0;               // output format: 0 text, 1 binary, 2 sparse
  bool is_closed = false;         // encl: the surfaces form an enclosure
  bool has_emissivities = false;  // emit: the output is Hottel's script-F in place of form factors
  uint32_t row = 0, column = 0;   // the only row and column to compute; 0: all
  uint32_t list = 0;
  double largest_distance = std::numeric_limits<double>::infinity();  // maxD
};

// A Vs3Surface is a line of the file that begins with S, M, N or O: a surface, mask, null surface or obstruction.
struct Vs3Surface {
  char kind = 'S';
  std::vector<glm::dvec3> corners;     // counter-clockwise seen from the active side
  uint32_t base = 0, merged_into = 0;  // numbers of surfaces, from 1; 0: none
  double emissivity = 0.9;             // clamped to the range 0.001 to 0.999, as View3D does
  std::string name;
  uint32_t line = 0;

  bool hasRow() const { return (kind == 'S' || kind == 'M') && merged_into == 0; }
};

struct Vs3File {
  std::string file, title;
  Vs3Control control;
  std::vector<Vs3Surface> surfaces;  // the surface of number k is surfaces[k - 1]
  std::vector<std::string> warnings;
};

// Reads a file.    Throws: Error bad_input naming file and line.
Vs3File parseVs3(const std::filesystem::path& file);

struct Vs3Scene {
  InputScene input;
  std::vector<uint32_t> surface_of;  // index into InputScene::surface_names of each surface of the file
};

// Makes the scene of a file. Subsurfaces and null surfaces are cut out of their bases, and merged surfaces become one.
//   In: merges: with false, surfaces that the file merges stay separate
//   Out: the surfaces that have a row, in the order of their numbers, then the surfaces that only block (O and N). A
//     null surface blocks where its base was cut out. A mask is face to face with its base. If several surfaces have
//     one name, the number is added: "wall#8".
//   Throws: Error bad_input, naming the line, where a subsurface does not lie in its base.    Cost: O(surfaces).
Vs3Scene makeScene(const Vs3File& file, bool merges = true);

}  // namespace viewpeel
