// A file of groups names the faces of a scene in a format without names: binary STL and PLY.
#pragma once
#include <filesystem>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Gives faces names from a .csv file with lines `face,name`, where face is a number from 1 or a range such as 12-40.
// A header `face,name`, empty lines, and comments after # are skipped. Names with commas or quotes are quoted as in RFC
// 4180. Faces that no line names keep their surface.
//   In: scene: from its reader
//   Throws: Error bad_input naming file and line: a face that does not exist, or that an earlier line names; a line
//     without a name.    Cost: O(faces + lines).
void nameFaces(const std::filesystem::path& groups, InputScene& scene);

// Reads a .stl or .ply file, names its faces, and builds the scene.
//   In: files, options: as in loadScene; groups: empty for no names
//   Throws: as loadScene and nameFaces; Error bad_usage for groups of another format, or of several files.
Scene loadGroupedScene(const std::vector<std::filesystem::path>& files, const std::filesystem::path& groups,
                       const SceneOptions& options);

// Reads a file without building the scene.    In: options: zones and outside count    Throws: as loadScene.
InputScene readScene(const std::filesystem::path& file, const SceneOptions& options);

// Reads several files into one, as loadScene of several files does.    Throws: as that.
InputScene readScene(const std::vector<std::filesystem::path>& files, const SceneOptions& options);

}  // namespace viewpeel
