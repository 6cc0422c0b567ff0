// An OpenFOAM case as its radiation model viewFactor sees it: coarse faces of the patches in the group viewFactorWall.
//   Source: OpenFOAM v1912, viewFactorsGen.C and viewFactor.C.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace viewpeel {

// A FoamRank is a part of a decomposed case, or the whole of a serial one.
struct FoamRank {
  // A coarse face is a row: fine faces that finalAgglom puts together.
  struct CoarseFace {
    std::string name;  // "heater.3", of a decomposed case "processor1/heater.3"; from 0, as OpenFOAM counts
    std::vector<uint64_t> of_mesh;  // indices of faces of polyMesh
  };
  std::filesystem::path folder;          // processorR/constant or constant, of a region with its name behind
  std::vector<CoarseFace> coarse_faces;  // in OpenFOAM's order: by patch, in it by number
};

// True where a folder is a case, or the constant folder of a region of one (CASE/constant/REGION).
bool isFoamCase(const std::filesystem::path& folder);

// Finds the files of all ranks. A case with processor folders is a decomposed one.
//   In: folder: the case, or CASE/constant/REGION
//   Throws: Error bad_input where there is no mesh, or both the whole mesh and processor folders have a finalAgglom.
//   Cost: O(ranks).
std::vector<std::filesystem::path> findFoamFolders(const std::filesystem::path& folder);

// Reads the patches and how their faces are put together. Without finalAgglom every face is a coarse face.
//   Throws: Error bad_input, naming file and line.    Cost: O(faces of the patches).
std::vector<FoamRank> readFoamCase(const std::filesystem::path& folder);

}  // namespace viewpeel
