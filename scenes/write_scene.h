// These functions write generated scenes to files.
#pragma once
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel::bench {

// Writes binary PLY in double precision. Equal corners are written once. PLY cannot name surfaces.
//   Throws: Error output where the file cannot be written.    Cost: O(corners).
void writePly(const InputScene& scene, const std::string& file);

// Writes binary STL, which has single precision, and only one surface.
//   In: triangles    Throws: Error bad_input for other faces, output where the file cannot be written.
//   Cost: O(triangles).
void writeStl(const InputScene& scene, const std::string& file);

}  // namespace viewpeel::bench
