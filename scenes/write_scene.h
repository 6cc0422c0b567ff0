// Writes generated scenes as files.
#pragma once
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel::bench {

// Binary PLY in double precision, equal corners written once; surfaces have no names in PLY.
//   Throws: Error output where the file cannot be written.    Cost: O(corners).
void writePly(const InputScene& scene, const std::string& file);

// Writes binary STL, which is in single precision and one surface.
//   In: triangles    Throws: Error bad_input for other faces, output where the file cannot be written.
//   Cost: O(triangles).
void writeStl(const InputScene& scene, const std::string& file);

}  // namespace viewpeel::bench
