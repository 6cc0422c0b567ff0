// readCcxDeck() reads from CalculiX's input deck what radiation between faces needs: *NODE, *ELEMENT, *ELSET, *INCLUDE
// and *RADIATE.
//   Source: G. Dhondt, CalculiX CrunchiX User's Manual, version 2.20: the keywords of these names; element faces.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A CcxFace is a face of an element that exchanges radiation: *RADIATE gives it the label R<face>CR.
struct CcxFace {
  uint64_t element = 0;
  uint32_t face = 0;                // number of the face within its element, from 1
  std::vector<glm::dvec3> corners;  // counter-clockwise seen from outside the solid, with mid nodes
  int cavity = 0;                   // value of CAVITY=: only faces of one cavity exchange radiation
  bool is_closed = false;           // the sink temperature is negative, which means that nothing leaves the cavity
  uint32_t line = 0;
};

struct CcxDeck {
  std::string file;
  std::vector<CcxFace> faces;  // in the order of CalculiX's rows
  std::vector<std::string> warnings;
};

// Reads a deck and the files it includes.
//   Out: faces by element number. Faces of one element are in the reverse of the deck's order, as in CalculiX 2.20.
//   Throws: Error bad_input naming file and line.    Cost: O(size of the files).
CcxDeck readCcxDeck(const std::filesystem::path& file);

}  // namespace viewpeel
