// Several files make one scene, as where each part of a model has a file.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Joins scenes into one, whose faces are in the order of the parts. Surface names are as loadScene() describes for
// several files.
//   In: parts: at least two, each from its reader
//   Throws: Error bad_input for a part without faces, and where two surfaces still have one name.
//   Cost: O(faces + surfaces log surfaces).
InputScene joinScenes(std::vector<InputScene> parts);

// Returns "FILE:LINE" of a face, or "FILE" where its format has no lines.
//   In: face: of input.faces    Cost: O(log files).
std::string placeOfFace(const InputScene& input, const InputFace& face);

}  // namespace viewpeel
