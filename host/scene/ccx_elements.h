// Faces of CalculiX's solid elements.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace viewpeel {

// Returns the number of nodes of an element type, such as C3D8R or DC3D10.    Out: 0 where the type has no solid faces
uint32_t ccxNodeCount(const std::string& type);

// Returns the nodes of a face, counter-clockwise from outside, from 0; quadratic elements have their mid nodes between.
//   In: node_count: as above; face: from 1    Out: empty where there is no such face
std::vector<uint32_t> ccxFaceNodes(uint32_t node_count, uint32_t face);

}  // namespace viewpeel
