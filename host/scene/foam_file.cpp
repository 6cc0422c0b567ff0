#include "scene/foam_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <zlib.h>

#include "scene/words.h"

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "binary lists are little-endian and copied as they are");

constexpr std::string_view kBlanks = " \t\r\n", kBrackets = ";{}()";
constexpr uint64_t kMostRepeated = 1u << 24;  // most faces in lists that give one value for all
constexpr uint64_t kMostBytes = 1ull << 36;   // largest file

// Reads a whole file. zlib passes files that are not compressed through unchanged.
std::string readAll(const std::filesystem::path& file) {
  std::string bytes;
  gzFile in = gzopen(file.c_str(), "rb");
  if (!in) FilePlace{file.string()}.refuse("cannot be read; check its permissions");
  std::vector<char> buffer(1 << 16);
  int got = 0;
  while ((got = gzread(in, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0 && bytes.size() < kMostBytes)
    bytes.append(buffer.data(), static_cast<size_t>(got));
  const int closed = gzclose(in);
  if (got < 0 || closed != Z_OK) FilePlace{file.string()}.refuse("is cut off or damaged; write the mesh again");
  return bytes;
}

}  // namespace

bool FoamFile::exists(const std::filesystem::path& file) {
  std::error_code failure;
  return std::filesystem::is_regular_file(file, failure) ||
         std::filesystem::is_regular_file(file.string() + ".gz", failure);
}

FoamFile::FoamFile(const std::filesystem::path& file) : file_(file.string()) {
  std::error_code failure;
  const bool is_plain = std::filesystem::is_regular_file(file, failure);
  if (!is_plain && !exists(file)) FilePlace{file_}.refuse("no such file; make the mesh of the case");
  if (!is_plain) file_ += ".gz";
  bytes_ = readAll(file_);
  readHeader();
}

void FoamFile::refuse(const std::string& what) const {
  const auto line =
      1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, bytes_.size())), '\n');
  FilePlace{file_, is_binary_ ? 0 : static_cast<uint32_t>(line)}.refuse(what);
}

void FoamFile::readHeader() {
  if (word() != "FoamFile" || word() != "{") {
    at_ = 0;
    refuse("not a file of OpenFOAM: it does not begin with FoamFile { }; write it again");
  }
  std::string format;
  for (std::string key = word(); key != "}"; key = word()) {
    if (key.empty()) refuse("the header has no end; write the file again");
    std::string value;
    for (std::string next = word(); next != ";"; next = word()) {
      if (next.empty() || next == "}") refuse("an entry of the header has no ';'; write the file again");
      value += next;
    }
    if (key == "format") format = value;
    if (key == "class") class_ = value;
    if (key != "arch") continue;
    if (value.find("MSB") != std::string::npos) refuse("the file is big-endian; write it as text");
    if (value.find("label=64") != std::string::npos) label_bytes_ = 8;
    if (value.find("scalar=32") != std::string::npos) scalar_bytes_ = 4;
  }
  is_binary_ = format == "binary";
}

void FoamFile::skipBlanks() {
  for (;;) {
    at_ = std::min(bytes_.find_first_not_of(kBlanks, at_), bytes_.size());
    const std::string_view rest = std::string_view(bytes_).substr(at_);
    if (rest.starts_with("//")) at_ = std::min(bytes_.find('\n', at_), bytes_.size());
    else if (rest.starts_with("/*")) at_ = std::min(bytes_.find("*/", at_ + 2), bytes_.size() - 2) + 2;
    else return;
  }
}

std::string FoamFile::word() {
  skipBlanks();
  if (at_ == bytes_.size()) return {};
  if (kBrackets.find(bytes_[at_]) != std::string_view::npos) return std::string(1, bytes_[at_++]);
  const size_t start = at_;
  if (bytes_[at_] == '"') {  // a string may have brackets in it
    at_ = std::min(bytes_.find('"', at_ + 1), bytes_.size() - 1) + 1;
    return bytes_.substr(start, at_ - start);
  }
  while (at_ < bytes_.size() && kBlanks.find(bytes_[at_]) == std::string_view::npos &&
         kBrackets.find(bytes_[at_]) == std::string_view::npos)
    ++at_;
  return bytes_.substr(start, at_ - start);
}

bool FoamFile::takes(char bracket) {
  skipBlanks();
  if (at_ == bytes_.size() || bytes_[at_] != bracket) return false;
  ++at_;
  return true;
}

void FoamFile::expect(char bracket, const char* what) {
  if (!takes(bracket)) refuse(fmt::format("'{}' is missing at {}; write the file again", bracket, what));
}

int64_t FoamFile::label(const char* what) {
  skipBlanks();
  int64_t value = 0;
  const auto [end, failure] = std::from_chars(bytes_.data() + at_, bytes_.data() + bytes_.size(), value);
  if (failure != std::errc()) refuse(fmt::format("{} is not a whole number; write the file again", what));
  at_ = static_cast<size_t>(end - bytes_.data());
  return value;
}

uint64_t FoamFile::count(const char* what) {
  const int64_t value = label(what);
  if (value < 0) refuse(fmt::format("{} is below 0; write the file again", what));
  return static_cast<uint64_t>(value);
}

double FoamFile::scalar(const char* what) {
  skipBlanks();
  double value = 0;
  const auto [end, failure] = std::from_chars(bytes_.data() + at_, bytes_.data() + bytes_.size(), value);
  if (failure == std::errc::invalid_argument || !std::isfinite(value))
    refuse(fmt::format("{} is not a finite number; correct it", what));
  at_ = static_cast<size_t>(end - bytes_.data());
  return value;
}

std::string_view FoamFile::raw(uint64_t bytes, const char* what) {
  if (bytes > bytes_.size() - at_) refuse(fmt::format("the file ends within {}; write it again", what));
  const std::string_view block = std::string_view(bytes_).substr(at_, bytes);
  at_ += bytes;
  return block;
}

std::vector<double> FoamFile::points() {
  const uint64_t n = count("the number of points");
  std::vector<double> values;
  if (n > bytes_.size()) refuse("the file ends within the points; write it again");
  values.reserve(3 * n);
  expect('(', "the points");
  if (is_binary_) {
    const std::string_view block = raw(3 * n * scalar_bytes_, "the points");
    for (uint64_t k = 0; k < 3 * n; ++k) {
      double value = 0;
      float single = 0;
      if (scalar_bytes_ == 8) std::memcpy(&value, block.data() + 8 * k, 8);
      else std::memcpy(&single, block.data() + 4 * k, 4);
      values.push_back(scalar_bytes_ == 8 ? value : double(single));
    }
  } else {
    for (uint64_t k = 0; k < n; ++k) {
      expect('(', "a point");
      for (int axis = 0; axis < 3; ++axis) values.push_back(scalar("a coordinate"));
      expect(')', "the end of a point");
    }
  }
  expect(')', "the end of the points");
  return values;
}

// Appends a list of labels: 4(0 1 0 1), 4{0}, 0() or, in binary files, 4 and the bytes in brackets.
void FoamFile::addLabels(FoamLists& lists, const char* what) {
  const uint64_t n = count(what);
  if (takes('{')) {
    repeated_ += n;
    if (n > kMostRepeated || repeated_ > kMostRepeated) refuse(fmt::format("{} are too many; correct it", what));
    lists.values.insert(lists.values.end(), n, label(what));
    expect('}', "the end of a list");
  } else if (n > 0 || !is_binary_) {
    expect('(', "a list");
    if (n > bytes_.size()) refuse(fmt::format("the file ends within {}; write it again", what));
    if (is_binary_) {
      const std::string_view block = raw(n * label_bytes_, what);
      for (uint64_t k = 0; k < n; ++k) {
        int64_t value = 0;
        int32_t narrow = 0;
        if (label_bytes_ == 8) std::memcpy(&value, block.data() + 8 * k, 8);
        else std::memcpy(&narrow, block.data() + 4 * k, 4);
        lists.values.push_back(label_bytes_ == 8 ? value : int64_t(narrow));
      }
    } else {
      for (uint64_t k = 0; k < n; ++k) lists.values.push_back(label(what));
    }
    expect(')', "the end of a list");
  }
  lists.starts.push_back(lists.values.size());
}

FoamLists FoamFile::lists() {
  const uint64_t n = count("the number of lists");
  FoamLists lists;
  expect('(', "the lists");
  for (uint64_t k = 0; k < n; ++k) addLabels(lists, "a list");
  expect(')', "the end of the lists");
  return lists;
}

FoamLists FoamFile::faces() {
  if (class_ != "faceCompactList") return lists();
  FoamLists starts, faces;
  addLabels(starts, "the starts of faces");
  addLabels(faces, "the points of faces");
  faces.starts.clear();
  for (int64_t start : starts.values) {
    if (start < 0 || static_cast<uint64_t>(start) > faces.values.size() ||
        (faces.starts.empty() ? start != 0 : static_cast<uint64_t>(start) < faces.starts.back()))
      refuse("a face starts out of range; write the file again");
    faces.starts.push_back(static_cast<uint64_t>(start));
  }
  if (faces.starts.empty()) faces.starts.push_back(0);
  return faces;
}

}  // namespace viewpeel
