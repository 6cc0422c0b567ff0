// Objects of EnergyPlus's two formats, before anybody looks at what they mean.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scene/words.h"

namespace viewpeel {

// An object of IDF: Type, field, field, ...; with comments behind '!'.
struct IdfObject {
  std::string type;  // in small letters
  std::vector<std::string> fields;
  FilePlace place;

  // Returns a field; empty where the object ends before.
  const std::string& field(size_t k) const;
};

// Reads all objects.    Throws: Error bad_input, naming the line, where the last one has no ';'.    Cost: O(bytes).
std::vector<IdfObject> readIdf(const std::filesystem::path& file);

// Reads the document, its members in the order of the file.    Throws: Error bad_input naming the line.
nlohmann::ordered_json readEpJson(const std::filesystem::path& file);

// Letters from A to Z are made small: names are told apart without regard to case.
std::string lowerCase(std::string text);

}  // namespace viewpeel
