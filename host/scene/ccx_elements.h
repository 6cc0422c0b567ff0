// These functions give the nodes and faces of CalculiX's solid elements.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace viewpeel {

// Returns the number of nodes of an element type, such as C3D8R or DC3D10; 0 for types that are not solid elements.
uint32_t ccxNodeCount(const std::string& type);

// Returns the nodes of a face, counted from 0 within the element. They run counter-clockwise seen from outside.
// Quadratic elements have the mid node of an edge between its two end nodes.
//   In: node_count: of the element type; face: counted from 1    Out: empty where there is no such face
std::vector<uint32_t> ccxFaceNodes(uint32_t node_count, uint32_t face);

}  // namespace viewpeel
