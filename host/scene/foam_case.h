// readFoamCase() reads an OpenFOAM case for its radiation model viewFactor: coarse faces of patches in viewFactorWall.
//   Source: OpenFOAM v1912, viewFactorsGen.C and viewFactor.C.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace viewpeel {

// A FoamRank is a part of a decomposed case, or the whole of a serial one.
struct FoamRank {
  // A CoarseFace is a row: fine faces that the file finalAgglom puts together.
  struct CoarseFace {
    std::string name;  // "heater.3", or in a decomposed case "processor1/heater.3"; numbers start at 0 as in OpenFOAM
    std::vector<uint64_t> of_mesh;  // indices of faces of polyMesh
  };
  std::filesystem::path folder;          // processorR/constant or constant, then the region's name if any
  std::vector<CoarseFace> coarse_faces;  // in OpenFOAM's order: by patch, then by number
};

// Returns whether a folder is a case, or the constant folder of one of its regions (CASE/constant/REGION).
bool isFoamCase(const std::filesystem::path& folder);

// Finds the files of all ranks. A case with processor folders is a decomposed one.
//   In: folder: the case, or CASE/constant/REGION
//   Throws: Error bad_input where there is no mesh, or both the whole mesh and processor folders have a finalAgglom.
//   Cost: O(ranks).
std::vector<std::filesystem::path> findFoamFolders(const std::filesystem::path& folder);

// Reads the patches, and which faces form a coarse face. Without finalAgglom every face is a coarse face.
//   Throws: Error bad_input, naming file and line.    Cost: O(faces of the patches).
std::vector<FoamRank> readFoamCase(const std::filesystem::path& folder);

}  // namespace viewpeel
