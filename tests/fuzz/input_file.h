// The fuzz targets share a file in memory, for readers take files and libFuzzer makes bytes. loadBytes() tests a reader
// of scenes.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel::fuzz {

// Returns the path of a file in memory with these bytes. Every call uses the same file.
std::filesystem::path makeFile(const uint8_t* bytes, size_t count);

// Reads the bytes as a scene and makes the checks before the first direction: it splits, groups and names faces, and
// looks for openings. Only an Error with one line may refuse a scene.
void loadBytes(InputScene (*read)(const std::filesystem::path&), const uint8_t* bytes, size_t count);

// Aborts unless the message is one line of printable text.
void requireOneLine(const std::string& message);

}  // namespace viewpeel::fuzz
