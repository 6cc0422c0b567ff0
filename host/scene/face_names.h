// These functions map names to faces. Messages, options and results use the names: "desk[3]" is the third face of
// surface desk in the file.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Returns the faces of a surface, or a single face, by name.
//   In: option: the program's option that the error message names    Out: indices into InputScene::faces
//   Throws: Error bad_usage where nothing has this name.    Cost: O(faces).
std::vector<uint32_t> findFaces(const InputScene& input, const std::string& name, const char* option);

// Says what an unknown name might have been meant to be: how many faces its surface has, or the nearest surface; and
// which surfaces there are.
//   In: surfaces: their names; face_counts: of each surface; empty where unknown
std::string explainUnknownName(const std::string& name, const std::vector<std::string>& surfaces,
                               const std::vector<uint32_t>& face_counts);

// Returns the name of the surface in the name of a face: "desk" for "desk[3]". Any other name is returned unchanged.
//   Cost: O(length).
std::string surfaceOfName(const std::string& name);

// Returns the names of all faces of a file, as faceName() makes them.    Cost: O(faces).
std::vector<std::string> nameFaces(const InputScene& input);

// Returns whether results and materials use a name themselves: `environment`, `environment:up`, `environment:down` and
// `leak`.
bool isReservedName(const std::string& name);

// Refuses files in which a surface has a reserved name, or the name of a face: a surface "desk[3]" beside a surface
// "desk" of three faces.
//   Throws: Error bad_input.
//   Cost: O(faces + surfaces log surfaces).
void requireDistinctNames(const InputScene& input);

}  // namespace viewpeel
