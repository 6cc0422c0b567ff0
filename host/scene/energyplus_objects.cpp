#include "scene/energyplus_objects.h"

#include <fstream>
#include <iterator>

#include "scene/json_text.h"

namespace viewpeel {
namespace {

// Returns a field without the blanks around it.
std::string withoutBlanks(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

}  // namespace

const std::string& IdfObject::field(size_t k) const {
  static const std::string none;
  return k < fields.size() ? fields[k] : none;
}

std::string lowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::vector<IdfObject> readIdf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<IdfObject> objects;
  std::vector<std::string> words;
  std::string word;
  FilePlace here{file.string()}, start;
  for (std::string line; std::getline(in, line);) {
    ++here.line;
    std::string_view text = here.line == 1 ? skipByteOrderMark(line) : std::string_view(line);
    text = text.substr(0, text.find('!'));
    for (char c : text) {
      if (c != ',' && c != ';') {
        if (words.empty() && word.empty()) {
          if (c == ' ' || c == '\t' || c == '\r') continue;
          start = here;
        }
        word += c;
        continue;
      }
      if (words.empty() && word.empty()) start = here;
      words.push_back(withoutBlanks(word));
      word.clear();
      if (c == ',') continue;
      objects.push_back({lowerCase(words[0]), {words.begin() + 1, words.end()}, start});
      words.clear();
    }
  }
  if (!words.empty() || !withoutBlanks(word).empty()) start.refuse("the object has no ';' at its end; complete it");
  return objects;
}

nlohmann::ordered_json readEpJson(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return parseJson({std::istreambuf_iterator<char>(in), {}}, FilePlace{file.string()});
}

}  // namespace viewpeel
