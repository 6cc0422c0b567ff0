// The fuzz targets share a file in memory, for readers take files and libFuzzer makes bytes.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel::fuzz {

// Returns the bytes as a file in memory, the same one for every call.
std::filesystem::path makeFile(const uint8_t* bytes, size_t count);

// Reads the bytes as a scene and does with it what every run does before the first direction: split, group, name, look
// for openings. Error is the one way in which a scene may be refused, in one line.
void loadBytes(InputScene (*read)(const std::filesystem::path&), const uint8_t* bytes, size_t count);

// Aborts unless the message is one line of printable text.
void requireOneLine(const std::string& message);

}  // namespace viewpeel::fuzz
