#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include <glm/glm.hpp>

#include "scene/read_vs3.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

constexpr double kDegree = 3.141592653589793238 / 180;
constexpr std::string_view kControls[] = {"eps",  "out",  "encl", "emit", "row",  "col", "list",
                                          "maxd", "maxu", "maxo", "mino", "prjd", "maxv"};
constexpr double kLeastEmissivity = 0.001, kLargestEmissivity = 0.999;

// Words are the words of a file. Blanks, commas and tabs separate them, `!` begins a comment, and `*` ends the data.
class Words {
 public:
  Words(std::string text, std::string file) : text_(std::move(text)), place_{std::move(file)} {
    rest_ = skipByteOrderMark(text_);
    place_.line = 1;
  }
  // Goes to the next line that has a word, and returns this word; empty at the end of the file.
  std::string_view nextEntry() {
    if (is_inside_line_) skipLine();
    is_inside_line_ = true;
    return nextOf(true);
  }
  // Returns the next word, from this line or a later one.
  std::string_view next(const char* what) {
    const std::string_view word = nextOf(true);
    if (word.empty()) place_.refuse(fmt::format("the file ends before {}; complete it", what));
    return word;
  }
  // Returns the next word of this line; empty where there is none.
  std::string_view nextInLine() { return nextOf(false); }
  std::string_view restOfLine() {
    const std::string_view line = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(line.size());
    return line;
  }
  void skipLine() { restOfLine(); }
  double number(const char* what) {
    const std::string_view word = next(what);
    return parseFinite(word, place_);
  }
  uint32_t whole(const char* what) {
    const std::string_view word = next(what);
    uint32_t value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc() || end != word.data() + word.size())
      place_.refuse(fmt::format("'{}' in the place of {} is not a whole number; correct it", printable(word), what));
    return value;
  }
  const FilePlace& place() const { return place_; }

 private:
  static bool isBetween(char c) { return c == ' ' || c == ',' || c == '\t' || c == '\r' || c == '\0'; }
  std::string_view nextOf(bool crosses_lines) {
    while (!rest_.empty()) {
      const char c = rest_.front();
      if (c == '*') return {};
      if (c == '!') {
        skipLine();
      } else if (c == '\n') {
        if (!crosses_lines) return {};
        ++place_.line;
        rest_.remove_prefix(1);
      } else if (isBetween(c)) {
        rest_.remove_prefix(1);
      } else {
        size_t length = 0;
        while (length < rest_.size() && !isBetween(rest_[length]) && rest_[length] != '\n') ++length;
        const std::string_view word = rest_.substr(0, length);
        rest_.remove_prefix(length);
        return word;
      }
    }
    return {};
  }
  std::string text_;
  std::string_view rest_;
  FilePlace place_;
  bool is_inside_line_ = false;
};

// A Counted counts the places of one fault and keeps the first, for a single warning.
struct Counted {
  uint64_t count = 0;
  uint32_t first_line = 0;
  void add(uint32_t line) {
    if (count++ == 0) first_line = line;
  }
};

class Parser {
 public:
  explicit Parser(const std::filesystem::path& path)
      : words_(readAll(path), path.string()), stem_(path.stem().string()) {
    file_.file = path.string();
  }

  Vs3File parse() {
    for (std::string_view word = words_.nextEntry(); !word.empty(); word = words_.nextEntry()) {
      const char kind = static_cast<char>(std::toupper(static_cast<unsigned char>(word.front())));
      if (kind == 'E') break;
      if (!readEntry(kind, word)) continue;
    }
    finish();
    return std::move(file_);
  }

 private:
  static std::string readAll(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[noreturn]] void refuse(const std::string& what) const { words_.place().refuse(what); }
  void warn(const std::string& what) {
    file_.warnings.push_back(fmt::format("{}:{}: {}", file_.file, words_.place().line, what));
  }

  bool readEntry(char kind, std::string_view word) {
    switch (kind) {
      case '/':
        return true;
      case 'T':
        file_.title = joinWords(words_.restOfLine());
        return true;
      case 'C':
        readControl(words_.restOfLine());
        return true;
      case 'F':
        readFormat();
        return true;
      case 'V':
        readVertex();
        return true;
      case 'S':
      case 'M':
      case 'N':
      case 'O':
        readSurface(kind);
        return true;
      case 'X':
        warn("coordinate transformations are not part of the format; the line is passed over");
        return true;
      default:
        warn(fmt::format("'{}' does not begin a line of the format; it is passed over", printable(word)));
        return false;
    }
  }

  void readFormat() {
    const std::string_view word = words_.nextInLine();
    is_blast_ = word == "3a" || word == "3A";
    if (word != "3" && !is_blast_)
      refuse(fmt::format("geometry 'F {}' is not known; give F 3 or F 3a", printable(word)));
  }

  void readControl(std::string_view line) {
    std::vector<std::string> words(1);
    for (char c : line.substr(0, line.find('!'))) {
      if (c == '=' || c == ' ' || c == ',' || c == '\t' || c == '\r') words.emplace_back();
      else words.back() += c;
    }
    std::erase(words, "");
    for (size_t k = 0; k < words.size();) {
      std::string name = words[k];
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (std::ranges::find(kControls, name) == std::end(kControls)) {
        warn(fmt::format("'{}' is not a control word; it is passed over", printable(words[k++])));
        continue;
      }
      if (k + 1 == words.size())
        refuse(fmt::format("'{}' has no value; complete the control line", printable(words[k])));
      setControl(name, words[k + 1]);
      k += 2;
    }
    if (file_.control.column && !file_.control.row) refuse("col needs row; give both");
  }

  // Settings of View3D's numerical integration are read and ignored.
  void setControl(const std::string& name, const std::string& value) {
    Vs3Control& control = file_.control;
    const double number = parseFinite(value, words_.place());
    const auto whole = [&](double least, double most) {
      if (number < least || number > most || number != std::floor(number))
        refuse(
            fmt::format("{}={} is not a whole number from {} to {}; correct it", name, printable(value), least, most));
      return static_cast<uint32_t>(number);
    };
    constexpr double kAny = 4294967295.0;
    if (name == "eps") {
      if (!(number > 0)) refuse(fmt::format("eps={} is not above 0; correct it", printable(value)));
      control.eps = number;
    } else if (name == "out") control.out = whole(0, 2);
    else if (name == "encl") control.is_closed = number != 0;
    else if (name == "emit") control.has_emissivities = number != 0;
    else if (name == "row") control.row = whole(0, kAny);
    else if (name == "col") control.column = whole(0, kAny);
    else if (name == "list") control.list = whole(0, kAny);
    else if (name == "maxd") control.largest_distance = number;
  }

  glm::dvec3 readPoint() {
    glm::dvec3 point;
    for (int axis = 0; axis < 3; ++axis) point[axis] = words_.number("a coordinate");
    return point;
  }

  void readVertex() {
    const uint32_t number = words_.whole("a vertex number");
    if (number != vertices_.size() + 1)
      refuse(fmt::format("vertex {} is out of sequence; {} comes next", number, vertices_.size() + 1));
    vertices_.push_back(readPoint());
  }

  void readSurface(char kind) {
    const uint32_t number = words_.whole("a surface number");
    if (number != file_.surfaces.size() + 1)
      refuse(fmt::format("surface {} is out of sequence; {} comes next", number, file_.surfaces.size() + 1));
    if (kind != 'O' && !file_.surfaces.empty() && file_.surfaces.back().kind == 'O')
      refuse(fmt::format("surface {} stands after an obstruction; move obstructions to the end", number));
    Vs3Surface surface;
    surface.kind = kind;
    surface.line = words_.place().line;
    if (is_blast_) {
      readPlacedSurface(surface);
    } else {
      std::vector<uint32_t> corners;
      for (int k = 0; k < 4; ++k) corners.push_back(words_.whole("a vertex number"));
      if (corners.back() == 0) corners.pop_back();
      corners_.push_back(corners);
      if (kind != 'O') readSurfaceData(surface);
    }
    file_.surfaces.push_back(std::move(surface));
  }

  void readSurfaceData(Vs3Surface& surface) {
    surface.base = words_.whole("a base surface number");
    surface.merged_into = words_.whole("a combine surface number");
    surface.emissivity = words_.number("an emissivity");
    if (surface.emissivity > kLargestEmissivity + 1e-5 || surface.emissivity < kLeastEmissivity - 1e-5)
      clamped_.add(words_.place().line);
    surface.emissivity = std::clamp(surface.emissivity, kLeastEmissivity, kLargestEmissivity);
    surface.name = words_.nextInLine();
  }

  // Reads a surface of F 3a. Its corners have x to the right and y upward in a plane with given origin, azimuth and
  // tilt.
  void readPlacedSurface(Vs3Surface& surface) {
    const std::string_view word = words_.next("a shape");
    const char shape = static_cast<char>(std::toupper(static_cast<unsigned char>(word.front())));
    if (shape != 'R' && shape != 'T' && shape != 'Q')
      refuse(fmt::format("'{}' is not a shape; give R, T or Q", printable(word)));
    if (surface.kind != 'O') readSurfaceData(surface);
    words_.skipLine();
    const glm::dvec3 origin = readPoint();
    const double azimuth = kDegree * words_.number("an azimuth"), tilt = kDegree * words_.number("a tilt");
    const glm::dvec3 right(-std::cos(azimuth), std::sin(azimuth), 0);
    const glm::dvec3 up(-std::cos(tilt) * std::sin(azimuth), -std::cos(tilt) * std::cos(azimuth), std::sin(tilt));
    std::vector<std::pair<double, double>> corners;
    if (shape == 'R') {
      const double width = words_.number("a width"), height = words_.number("a height");
      corners = {{0, height}, {0, 0}, {width, 0}, {width, height}};
    } else {
      for (int k = 0; k < (shape == 'T' ? 3 : 4); ++k) {
        const double x = words_.number("a coordinate");
        corners.emplace_back(x, words_.number("a coordinate"));
      }
    }
    for (const auto& corner : corners) surface.corners.push_back(origin + corner.first * right + corner.second * up);
  }

  // Checks numbers of vertices and surfaces at the end, because both may come in any order.
  void finish() {
    for (size_t k = 0; k < corners_.size() && !is_blast_; ++k)
      for (uint32_t number : corners_[k]) {
        if (number < 1 || number > vertices_.size())
          FilePlace{file_.file, file_.surfaces[k].line}.refuse(
              fmt::format("vertex {} of surface {} is out of range; the file has {}", number, k + 1, vertices_.size()));
        file_.surfaces[k].corners.push_back(vertices_[number - 1]);
      }
    for (uint32_t k = 1; k <= file_.surfaces.size(); ++k) checkSurface(k);
    const auto count = static_cast<uint32_t>(file_.surfaces.size());
    if (file_.control.row > count || file_.control.column > count)
      FilePlace{file_.file}.refuse(
          fmt::format("row or col is larger than the number of surfaces, {}; correct it", count));
    if (clamped_.count)
      file_.warnings.push_back(fmt::format("{}:{}: {} emissivit{} outside 0.001 to 0.999 moved there, this one first",
                                           file_.file, clamped_.first_line, clamped_.count,
                                           clamped_.count == 1 ? "y" : "ies"));
  }

  void checkSurface(uint32_t number) const {
    const Vs3Surface& surface = file_.surfaces[number - 1];
    const FilePlace place{file_.file, surface.line};
    const auto count = static_cast<uint32_t>(file_.surfaces.size());
    const uint32_t base = surface.base, merged = surface.merged_into;
    if (base > count) place.refuse(fmt::format("base surface {} is out of range; the file has {}", base, count));
    if (base && file_.surfaces[base - 1].kind != 'O' && base >= number)
      place.refuse(fmt::format("surface {} stands before its base {}; exchange them", number, base));
    if (base && (file_.surfaces[base - 1].kind == 'M' || file_.surfaces[base - 1].kind == 'N'))
      place.refuse(fmt::format("base {} is a mask or a null surface; name a surface S or O", base));
    if ((surface.kind == 'M' || surface.kind == 'N') && base == 0)
      place.refuse(fmt::format("mask or null surface {} needs a base; name one", number));
    if (merged == 0) return;
    if (surface.kind != 'S') place.refuse(fmt::format("surface {} cannot be combined; only surfaces S can", number));
    if (merged >= number)
      place.refuse(fmt::format("surface {} is combined with {}, which is not before it", number, merged));
    const Vs3Surface& target = file_.surfaces[merged - 1];
    if (target.merged_into)
      place.refuse(fmt::format("surface {} is combined with {}, which is combined itself", number, merged));
    if (target.kind != 'S')
      place.refuse(fmt::format("surface {} is combined with {}, which is not a surface S", number, merged));
  }

  Words words_;
  std::string stem_;
  Vs3File file_;
  bool is_blast_ = false;
  std::vector<glm::dvec3> vertices_;
  std::vector<std::vector<uint32_t>> corners_;  // of each surface of F 3
  Counted clamped_;
};

}  // namespace

Vs3File parseVs3(const std::filesystem::path& file) { return Parser(file).parse(); }

}  // namespace viewpeel
