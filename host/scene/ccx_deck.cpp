#include "scene/ccx_deck.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include <glm/glm.hpp>

#include "scene/ccx_elements.h"
#include "scene/cut_away.h"
#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

constexpr int kMostIncludes = 16;  // depth to which included files may include others
// A face is curved if a corner is farther from its mean plane than this times its size.
constexpr double kElementFlatness = 1e-6;
constexpr uint64_t kMostGenerated = 1u << 30;

// Splits a line at commas. As CalculiX does, it removes all blanks and turns letters into capitals.
std::vector<std::string> splitParts(std::string_view line) {
  std::vector<std::string> parts(1);
  for (char c : line) {
    if (c == ',') parts.emplace_back();
    else if (c != ' ' && c != '\t' && c != '\r')
      parts.back() += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return parts;
}

class DeckReader {
 public:
  CcxDeck read(const std::filesystem::path& file) {
    deck_.file = file.string();
    readFile(file, 0);
    finishElement();
    finish();
    return std::move(deck_);
  }

 private:
  struct Element {
    uint32_t node_count = 0;  // 0: the type is not a solid element
    std::vector<uint64_t> nodes;
    FilePlace place;
  };
  // A Radiating is a line of *RADIATE. It is kept until the whole deck is read, because its element set may come later.
  struct Radiating {
    std::string name;
    uint32_t face;
    int cavity;
    bool is_closed;
    FilePlace place;
  };
  using Parameters = std::map<std::string, std::string>;

  void readFile(const std::filesystem::path& file, int depth) {
    if (depth > kMostIncludes) place_.refuse("includes are nested too deeply; does a file include itself?");
    std::ifstream in(file, std::ios::binary);
    if (!in)
      place_.refuse(fmt::format("the included file {} cannot be read; check the name", printable(file.string())));
    const FilePlace outer = std::exchange(place_, FilePlace{file.string()});
    for (std::string line; std::getline(in, line);) {
      ++place_.line;
      std::string_view text = place_.line == 1 ? skipByteOrderMark(line) : std::string_view(line);
      if (text.starts_with("**") || text.find_first_not_of(" \t\r") == std::string_view::npos) continue;
      if (text.starts_with("*")) readKeyword(text, file, depth);
      else readData(splitParts(text));
    }
    place_ = outer;
  }

  void readKeyword(std::string_view line, const std::filesystem::path& file, int depth) {
    finishElement();
    const std::vector<std::string> parts = splitParts(line);
    keyword_ = parts[0];
    parameters_.clear();
    for (size_t k = 1; k < parts.size(); ++k) {
      const size_t equals = parts[k].find('=');
      parameters_[parts[k].substr(0, equals)] = equals == std::string::npos ? "" : parts[k].substr(equals + 1);
    }
    if (keyword_ == "*INCLUDE") {
      readFile(includedFile(line, file), depth + 1);
      keyword_.clear();
    }
    if (keyword_ == "*ELEMENT") node_count_ = ccxNodeCount(parameters_["TYPE"]);
    if (keyword_ == "*SURFACE") surfaces_.insert(parameters_["NAME"]);
    if (keyword_ == "*RADIATE" && parameters_["OP"] == "NEW") radiating_.clear();
  }

  // Returns the name of the included file as it is written, without turning letters into capitals.
  std::filesystem::path includedFile(std::string_view line, const std::filesystem::path& file) const {
    const size_t equals = line.find('=');
    if (equals == std::string_view::npos) place_.refuse("*INCLUDE has no INPUT=; complete it");
    std::string name = joinWords(line.substr(equals + 1));
    if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    return std::filesystem::path(name).is_absolute() ? std::filesystem::path(name) : file.parent_path() / name;
  }

  uint64_t whole(const std::string& word) const {
    uint64_t value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc() || end != word.data() + word.size())
      place_.refuse(fmt::format("'{}' is not a whole number; correct it", printable(word)));
    return value;
  }
  static bool isNumber(const std::string& word) {
    return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
  }

  void readData(const std::vector<std::string>& parts) {
    if (keyword_ == "*NODE") readNode(parts);
    else if (keyword_ == "*ELEMENT") readElement(parts);
    else if (keyword_ == "*ELSET") readSet(parts);
    else if (keyword_ == "*RADIATE") readRadiate(parts);
  }

  // Adds a node. A coordinate that the line leaves out is 0.
  void readNode(const std::vector<std::string>& parts) {
    glm::dvec3 point(0);
    for (size_t axis = 0; axis < 3 && axis + 1 < parts.size(); ++axis)
      if (!parts[axis + 1].empty()) point[static_cast<int>(axis)] = parseNumber(parts[axis + 1]);
    nodes_[whole(parts[0])] = point;
  }

  // Returns the number that a word spells. The exponent may have Fortran's D: 1.D3.
  double parseNumber(std::string word) const {
    std::replace(word.begin(), word.end(), 'D', 'E');
    return parseFinite(word, place_);
  }

  // Reads a line of an element, whose nodes may take several lines.
  void readElement(const std::vector<std::string>& parts) {
    size_t k = 0;
    if (!is_inside_element_) {
      element_number_ = whole(parts[k++]);
      element_ = Element{node_count_, {}, place_};
      is_inside_element_ = true;
    }
    for (; k < parts.size(); ++k)
      if (!parts[k].empty()) element_.nodes.push_back(whole(parts[k]));
    // Where the number of nodes is unknown, a comma at the end of a line means that the next line belongs to the
    // element.
    if (node_count_ ? element_.nodes.size() >= node_count_ : !parts.back().empty()) finishElement();
  }

  void finishElement() {
    if (!is_inside_element_) return;
    is_inside_element_ = false;
    if (element_.nodes.size() < element_.node_count)
      element_.place.refuse(fmt::format("element {} has {} nodes in place of {}; complete it", element_number_,
                                        element_.nodes.size(), element_.node_count));
    elements_[element_number_] = std::move(element_);
    if (const std::string& set = parameters_["ELSET"]; !set.empty()) sets_[set].insert(element_number_);
  }

  void readSet(const std::vector<std::string>& parts) {
    std::set<uint64_t>& set = sets_[parameters_["ELSET"]];
    if (parameters_.count("GENERATE")) {
      const uint64_t first = whole(parts[0]), last = parts.size() > 1 ? whole(parts[1]) : first;
      const uint64_t step = parts.size() > 2 && !parts[2].empty() ? whole(parts[2]) : 1;
      if (step == 0 || last < first || (last - first) / step > kMostGenerated)
        place_.refuse("the range of GENERATE is not one; correct it");
      // Only numbers of existing elements are kept. A range of a billion numbers would not fit into memory.
      for (auto at = elements_.lower_bound(first); at != elements_.end() && at->first <= last; ++at)
        if ((at->first - first) % step == 0) set.insert(at->first);
      return;
    }
    for (const std::string& part : parts) {
      if (part.empty()) continue;
      if (isNumber(part)) {
        set.insert(whole(part));
      } else if (const auto other = sets_.find(part); other != sets_.end()) {
        const std::set<uint64_t> members = other->second;
        set.insert(members.begin(), members.end());
      } else {
        place_.refuse(fmt::format("element set '{}' is not known here; define it before", printable(part)));
      }
    }
  }

  void readRadiate(const std::vector<std::string>& parts) {
    if (parts.size() < 2) place_.refuse("a line of *RADIATE needs an element and a label; complete it");
    const std::string& label = parts[1];
    if (!label.starts_with("R") || !label.ends_with("CR")) return;  // radiation to the environment alone
    const std::string face = label.substr(1, label.size() - 3);
    if (!isNumber(face))
      place_.refuse(fmt::format("label '{}' names no face of a solid; use R1CR to R6CR", printable(label)));
    const double sink =
        parts.size() > 2 && !parts[2].empty() && !parameters_.count("ENVNODE") ? parseNumber(parts[2]) : 0;
    radiating_.push_back({parts[0], static_cast<uint32_t>(std::min<uint64_t>(whole(face), 99)),
                          std::atoi(parameters_["CAVITY"].substr(0, 3).c_str()), sink < 0, place_});
  }

  void finish() {
    std::map<uint64_t, std::vector<CcxFace>> by_element;
    for (const Radiating& line : radiating_) {
      if (isNumber(line.name)) {
        addFace(std::strtoull(line.name.c_str(), nullptr, 10), line, by_element);
      } else if (const auto set = sets_.find(line.name); set != sets_.end()) {
        for (uint64_t element : set->second) addFace(element, line, by_element);
      } else if (surfaces_.count(line.name)) {
        line.place.refuse(
            fmt::format("'{}' is a surface, which CalculiX does not take in *RADIATE; name elements or an "
                        "element set",
                        printable(line.name)));
      } else {
        line.place.refuse(fmt::format("element set '{}' is not known; define it", printable(line.name)));
      }
    }
    for (auto& [element, faces] : by_element)
      for (auto face = faces.rbegin(); face != faces.rend(); ++face) deck_.faces.push_back(std::move(*face));
    if (deck_.faces.empty())
      FilePlace{deck_.file}.refuse("no face exchanges radiation; give lines like '1,R2CR,300.,0.9' below *RADIATE");
    if (curved_count_)
      deck_.warnings.push_back(fmt::format(
          "{}: {} of {} radiating faces are curved, {}.R{} first; CalculiX leaves out of the flux what such a face "
          "sends to itself",
          deck_.file, curved_count_, deck_.faces.size(), first_curved_.first, first_curved_.second));
  }

  void addFace(uint64_t number, const Radiating& line, std::map<uint64_t, std::vector<CcxFace>>& by_element) {
    const auto element = elements_.find(number);
    if (element == elements_.end()) line.place.refuse(fmt::format("there is no element {}; correct it", number));
    const std::vector<uint32_t> nodes =
        element->second.node_count ? ccxFaceNodes(element->second.node_count, line.face) : std::vector<uint32_t>{};
    if (nodes.empty())
      line.place.refuse(
          fmt::format("element {} has no face {} of a solid; only C3D4 to C3D20 have faces here", number, line.face));
    CcxFace face{number, line.face, {}, line.cavity, line.is_closed, line.place.line};
    for (uint32_t node : nodes) {
      const auto point = nodes_.find(element->second.nodes[node]);
      if (point == nodes_.end())
        element->second.place.refuse(
            fmt::format("element {} has node {}, which is not there", number, element->second.nodes[node]));
      face.corners.push_back(point->second);
    }
    noteCurved(face);
    std::vector<CcxFace>& others = by_element[number];
    const auto same = std::ranges::find(others, face.face, &CcxFace::face);
    if (same != others.end()) *same = std::move(face);
    else others.push_back(std::move(face));
  }

  void noteCurved(const CcxFace& face) {
    const glm::dvec3 normal = twiceAreaNormal(face.corners);
    const double size = std::sqrt(glm::length(normal));
    double off = 0;
    for (const glm::dvec3& corner : face.corners)
      off = std::max(off, std::abs(glm::dot(normal, corner - face.corners[0])) / (size * size));
    if (off > kElementFlatness * size && curved_count_++ == 0) first_curved_ = {face.element, face.face};
  }

  CcxDeck deck_;
  FilePlace place_;
  std::string keyword_;
  Parameters parameters_;
  uint32_t node_count_ = 0;
  bool is_inside_element_ = false;
  uint64_t element_number_ = 0;
  Element element_;
  std::unordered_map<uint64_t, glm::dvec3> nodes_;
  std::map<uint64_t, Element> elements_;
  std::map<std::string, std::set<uint64_t>> sets_;
  std::set<std::string> surfaces_;
  std::vector<Radiating> radiating_;
  uint64_t curved_count_ = 0;
  std::pair<uint64_t, uint32_t> first_curved_;
};

}  // namespace

CcxDeck readCcxDeck(const std::filesystem::path& file) { return DeckReader().read(file); }

InputScene readInp(const std::filesystem::path& file) {
  CcxDeck deck = readCcxDeck(file);
  InputScene scene{deck.file, {}, {}, std::move(deck.warnings)};
  for (CcxFace& face : deck.faces) {
    scene.faces.push_back({std::move(face.corners), static_cast<uint32_t>(scene.surface_names.size()), face.line});
    scene.surface_names.push_back(fmt::format("{}.R{}", face.element, face.face));
  }
  return scene;
}

}  // namespace viewpeel
