// Reads CalculiX's input deck, as far as radiation between faces goes: *NODE, *ELEMENT, *ELSET, *INCLUDE and *RADIATE.
//   Source: G. Dhondt, CalculiX CrunchiX User's Manual, version 2.20: keywords of these names; element faces.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A label R<face>CR of *RADIATE makes a face exchange radiation.
struct CcxFace {
  uint64_t element = 0;
  uint32_t face = 0;                // from 1
  std::vector<glm::dvec3> corners;  // counter-clockwise from outside the solid, mid nodes included
  int cavity = 0;                   // number of CAVITY=, by which CalculiX tells cavities apart
  bool is_closed = false;           // its sink temperature is negative: nothing leaves the cavity
  uint32_t line = 0;
};

struct CcxDeck {
  std::string file;
  std::vector<CcxFace> faces;  // in the order of CalculiX's rows
  std::vector<std::string> warnings;
};

// Reads a deck and the files it includes.
//   Out: faces by element number; those of one element in the reverse of the deck's order, as CalculiX 2.20 has them
//   Throws: Error bad_input naming file and line.    Cost: O(size of the files).
CcxDeck readCcxDeck(const std::filesystem::path& file);

}  // namespace viewpeel
