#include "scene/foam_case.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "scene/foam_file.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGroup = "viewFactorWall";
constexpr uint64_t kMostFaces = 1u << 31;

bool hasMesh(const fs::path& constant) { return FoamFile::exists(constant / "polyMesh" / "boundary"); }

// Returns the case and the region of a folder: CASE or CASE/constant/REGION.
std::optional<std::pair<fs::path, fs::path>> locate(const fs::path& folder) {
  if (hasMesh(folder / "constant") || hasMesh(folder / "processor0/constant")) return std::pair(folder, fs::path());
  std::error_code failure;
  const fs::path whole = fs::weakly_canonical(fs::absolute(folder, failure), failure);
  if (whole.parent_path().filename() != "constant") return std::nullopt;
  const fs::path root = whole.parent_path().parent_path(), region = whole.filename();
  if (hasMesh(whole) || hasMesh(root / "processor0/constant" / region)) return std::pair(root, region);
  return std::nullopt;
}

struct Patch {
  std::string name;
  uint64_t start = 0, count = 0;
  bool radiates = false;
};

// Reads the entries of one patch, up to its closing bracket.
Patch readPatch(FoamFile& file) {
  Patch patch{file.word()};
  if (file.word() != "{") file.refuse("a patch has no '{'; write the file again");
  bool has_start = false, has_count = false;
  const auto skip = [&] {  // skips a dictionary within the patch
    for (int depth = 1; depth > 0;) {
      const std::string word = file.word();
      if (word.empty()) file.refuse("a patch has no end; write the file again");
      depth += word == "{" ? 1 : word == "}" ? -1 : 0;
    }
  };
  const auto number = [&](bool& has) {
    const uint64_t value = file.count("a number of the patch");
    if (value > kMostFaces) file.refuse("a patch is out of range; write the file again");
    has = true;
    return value;
  };
  for (std::string key = file.word(); key != "}"; key = file.word()) {
    if (key.empty()) file.refuse("a patch has no end; write the file again");
    if (key == "nFaces") patch.count = number(has_count);
    if (key == "startFace") patch.start = number(has_start);
    for (std::string value = file.word(); value != ";"; value = file.word()) {
      if (value.empty() || value == "}") file.refuse("an entry of a patch has no ';'; write the file again");
      if (value == "{") {
        skip();
        break;
      }
      if (key == "inGroups" && value == kGroup) patch.radiates = true;
    }
  }
  if (!has_start || !has_count)
    file.refuse(fmt::format("patch '{}' has no nFaces or no startFace; write the file again", printable(patch.name)));
  return patch;
}

std::vector<Patch> readPatches(const fs::path& folder) {
  FoamFile file(folder / "polyMesh" / "boundary");
  const uint64_t n = file.count("the number of patches");
  if (file.word() != "(") file.refuse("'(' is missing before the patches; write the file again");
  std::vector<Patch> patches;
  for (uint64_t k = 0; k < n; ++k) patches.push_back(readPatch(file));
  return patches;
}

// Reads the number of the coarse face of each face, patch by patch.
FoamLists readAgglomeration(const fs::path& folder, const std::vector<Patch>& patches) {
  const FoamLists coarse = FoamFile(folder / "finalAgglom").lists();
  const FilePlace file{(folder / "finalAgglom").string()};
  if (coarse.count() != patches.size())
    file.refuse(fmt::format("it is of {} patches, and the mesh has {}; run faceAgglomerate again", coarse.count(),
                            patches.size()));
  for (size_t p = 0; p < patches.size(); ++p) {
    if (!patches[p].radiates) continue;
    if (coarse.size(p) != patches[p].count)
      file.refuse(fmt::format("patch '{}' has {} faces here, and {} in the mesh; run faceAgglomerate again",
                              printable(patches[p].name), coarse.size(p), patches[p].count));
    for (uint64_t k = 0; k < coarse.size(p); ++k)
      if (coarse.begin(p)[k] < 0 || static_cast<uint64_t>(coarse.begin(p)[k]) >= coarse.size(p))
        file.refuse(fmt::format("patch '{}' has a coarse face {} out of range; run faceAgglomerate again",
                                printable(patches[p].name), coarse.begin(p)[k]));
  }
  return coarse;
}

void addCoarseFaces(const Patch& patch, const int64_t* coarse, const std::string& prefix, FoamRank& rank) {
  uint64_t count = patch.count;
  if (coarse) count = patch.count ? 1 + static_cast<uint64_t>(*std::max_element(coarse, coarse + patch.count)) : 0;
  const size_t first = rank.coarse_faces.size();
  for (uint64_t k = 0; k < count; ++k) rank.coarse_faces.push_back({fmt::format("{}{}.{}", prefix, patch.name, k), {}});
  for (uint64_t k = 0; k < patch.count; ++k)
    rank.coarse_faces[first + (coarse ? static_cast<uint64_t>(coarse[k]) : k)].of_mesh.push_back(patch.start + k);
  for (size_t k = first; k < rank.coarse_faces.size(); ++k)
    if (rank.coarse_faces[k].of_mesh.empty())
      FilePlace{(rank.folder / "finalAgglom").string()}.refuse(fmt::format(
          "coarse face {} of patch '{}' has no face; run faceAgglomerate again", k - first, printable(patch.name)));
}

}  // namespace

bool isFoamCase(const fs::path& folder) { return locate(folder).has_value(); }

std::vector<fs::path> findFoamFolders(const fs::path& folder) {
  const auto place = locate(folder);
  if (!place)
    FilePlace{folder.string()}.refuse(
        "is a directory without constant/polyMesh; name a scene file, or an OpenFOAM case after its mesh is made");
  const fs::path &root = place->first, &region = place->second;
  const auto folderOf = [&](const fs::path& part) {
    return region.empty() ? root / part / "constant" : root / part / "constant" / region;
  };
  const fs::path whole = folderOf("");
  if (!hasMesh(folderOf("processor0"))) return {whole};
  if (FoamFile::exists(whole / "finalAgglom") && hasMesh(whole)) {
    if (FoamFile::exists(folderOf("processor0") / "finalAgglom"))
      FilePlace{whole.string()}.refuse(
          "both the whole mesh and processor0 have a finalAgglom; remove the one that is not to be used");
    return {whole};
  }
  std::vector<fs::path> folders;
  for (uint32_t rank = 0; hasMesh(folderOf(fmt::format("processor{}", rank))); ++rank)
    folders.push_back(folderOf(fmt::format("processor{}", rank)));
  return folders;
}

std::vector<FoamRank> readFoamCase(const fs::path& folder) {
  std::vector<FoamRank> ranks;
  const std::vector<fs::path> folders = findFoamFolders(folder);
  bool has_faces = false;
  for (const fs::path& of_rank : folders) {
    FoamRank rank{of_rank, {}};
    const std::vector<Patch> patches = readPatches(of_rank);
    const bool is_coarse = FoamFile::exists(of_rank / "finalAgglom");
    const FoamLists coarse = is_coarse ? readAgglomeration(of_rank, patches) : FoamLists{};
    const std::string prefix = folders.size() == 1 ? "" : fmt::format("processor{}/", ranks.size());
    for (size_t p = 0; p < patches.size(); ++p)
      if (patches[p].radiates) addCoarseFaces(patches[p], is_coarse ? coarse.begin(p) : nullptr, prefix, rank);
    has_faces = has_faces || !rank.coarse_faces.empty();
    ranks.push_back(std::move(rank));
  }
  if (!has_faces)
    FilePlace{(folders[0] / "polyMesh" / "boundary").string()}.refuse(
        fmt::format("no patch is in the group {}; add it to inGroups of the patches that exchange radiation", kGroup));
  return ranks;
}

}  // namespace viewpeel
