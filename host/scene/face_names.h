// Names of faces in messages, options and results: "desk[3]" is the third face of surface desk in the file.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Returns the faces of the surface of this name, or the one face.
//   In: option: named in the message    Out: indices into InputScene::faces
//   Throws: Error bad_usage where there is none.    Cost: O(faces).
std::vector<uint32_t> findFaces(const InputScene& input, const std::string& name, const char* option);

// Returns the surface in a name as faceName makes them for surfaces of several faces: "desk" of "desk[3]", and any
// other name as it is.    Cost: O(length).
std::string surfaceOfName(const std::string& name);

// Names of all faces of a file, as faceName gives them.    Cost: O(faces).
std::vector<std::string> nameFaces(const InputScene& input);

//   Throws: Error bad_input where a surface has the name of another one's face, as "desk[3]" beside a desk of three
//   faces.
//   Cost: O(faces + surfaces log surfaces).
void requireDistinctNames(const InputScene& input);

}  // namespace viewpeel
