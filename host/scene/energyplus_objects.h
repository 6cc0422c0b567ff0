// These functions read the objects of EnergyPlus's two formats, without interpreting them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scene/words.h"

namespace viewpeel {

// An IdfObject is an object of IDF: Type, field, field, ...; a comment begins with '!'.
struct IdfObject {
  std::string type;  // in small letters
  std::vector<std::string> fields;
  FilePlace place;

  // Returns a field; empty if the object has fewer fields.
  const std::string& field(size_t k) const;
};

// Reads all objects.    Throws: Error bad_input, naming the line, where the last object has no ';'.    Cost: O(bytes).
std::vector<IdfObject> readIdf(const std::filesystem::path& file);

// Reads the document, with its members in the order of the file.    Throws: Error bad_input naming the line.
nlohmann::ordered_json readEpJson(const std::filesystem::path& file);

// Returns a text with A to Z made small, for EnergyPlus compares names without regard to case.
std::string lowerCase(std::string text);

}  // namespace viewpeel
