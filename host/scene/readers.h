// One reader per family of formats. The file is known to exist and to be readable.
#pragma once
#include "scene/scene.h"

namespace viewpeel {

//   Throws: Error bad_input naming file and line.
InputScene readObj(const std::filesystem::path& file);

// .stl and .ply, through Assimp, which keeps coordinates in single precision.
//   Throws: Error bad_input naming the file, and the line of a coordinate that is not finite.
InputScene readWithAssimp(const std::filesystem::path& file);

}  // namespace viewpeel
