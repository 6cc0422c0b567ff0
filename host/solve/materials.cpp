#include <viewpeel/solve.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include <fmt/format.h>

#include "io/csv.h"
#include "scene/words.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr std::array<const char*, 4> kColumns{"surface", "emissivity", "temperature", "heat_flux"};
enum Column { kSurface, kEmissivity, kTemperature, kHeatFlux };
using Line = MaterialTable::Line;
using Fields = std::array<std::string, kColumns.size()>;

// Returns whether a text fits a pattern, in which * stands for any characters and ? for one.
bool fits(std::string_view pattern, std::string_view text) {
  size_t p = 0, t = 0, star = std::string_view::npos, after_star = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++, after_star = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p, ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1, t = ++after_star;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

bool hasWildcard(const std::string& name) { return name.find_first_of("*?") != std::string::npos; }

// Returns the column of each field of the header.
std::vector<size_t> readHeader(const std::vector<std::string>& names, const FilePlace& place) {
  std::vector<size_t> columns;
  for (const std::string& name : names) {
    const auto at = std::ranges::find(kColumns, name);
    if (at == kColumns.end())
      place.refuse(
          fmt::format("'{}' is not a column of materials; the header is surface,emissivity,temperature,heat_flux",
                      printable(name)));
    columns.push_back(static_cast<size_t>(at - kColumns.begin()));
  }
  for (size_t k = 0; k < kColumns.size(); ++k)
    if (std::ranges::count(columns, k) != 1)
      place.refuse(
          fmt::format("the header needs the column '{}' once: surface,emissivity,temperature,heat_flux", kColumns[k]));
  return columns;
}

double readTemperature(const std::string& field, const FilePlace& place) {
  const double temperature = parseFinite(field, place);
  if (temperature < 0) place.refuse(fmt::format("a temperature of {} K is below 0; give kelvins", field));
  return temperature;
}

Material readMaterial(const Fields& fields, const FilePlace& place) {
  Material material;
  material.emissivity = parseFinite(fields[kEmissivity], place);
  if (!(material.emissivity > 0 && material.emissivity <= 1))
    place.refuse(fmt::format("an emissivity of {} is not above 0 and up to 1; correct it", fields[kEmissivity]));
  if (fields[kTemperature].empty() == fields[kHeatFlux].empty())
    place.refuse(fmt::format("'{}' has {} temperature {} heat_flux; give one of the two", printable(fields[kSurface]),
                             fields[kTemperature].empty() ? "neither" : "both",
                             fields[kTemperature].empty() ? "nor" : "and"));
  if (!fields[kTemperature].empty()) material.temperature = readTemperature(fields[kTemperature], place);
  else material.heat_flux = fields[kHeatFlux] == "adiabatic" ? 0 : parseFinite(fields[kHeatFlux], place);
  return material;
}

void readEnvironment(const Fields& fields, const FilePlace& place, MaterialTable& table) {
  if (table.environment_temperature) place.refuse("'environment' has a line already; remove one");
  const bool is_black = fields[kEmissivity].empty() || parseFinite(fields[kEmissivity], place) == 1;
  if (!is_black || fields[kTemperature].empty() || !fields[kHeatFlux].empty())
    place.refuse("'environment' is black and has a temperature alone; write environment,,KELVIN,");
  table.environment_temperature = readTemperature(fields[kTemperature], place);
}

// Names of faces and surfaces, and which of them the lines have named.
class LineFinder {
 public:
  explicit LineFinder(const MaterialTable& table) : table_(table), is_used_(table.lines.size()) {
    for (size_t k = 0; k < table.lines.size(); ++k) of_name_[table.lines[k].name] = k;
  }

  // Marks the lines that name a face or surface. Returns the strongest: by its name, else the last by wildcards.
  const Line* find(const std::string& name) {
    const auto exact = of_name_.find(name);
    const Line* found = nullptr;
    for (size_t k = 0; k < table_.lines.size(); ++k) {
      const bool is_exact = exact != of_name_.end() && exact->second == k;
      if (!is_exact && !(hasWildcard(table_.lines[k].name) && fits(table_.lines[k].name, name))) continue;
      is_used_[k] = true;
      found = &table_.lines[k];
    }
    return exact != of_name_.end() ? &table_.lines[exact->second] : found;
  }
  const Line* byDefault() const {
    const auto found = of_name_.find("default");
    return found == of_name_.end() ? nullptr : &table_.lines[found->second];
  }
  const Line* firstUnused() const {
    for (size_t k = 0; k < is_used_.size(); ++k)
      if (!is_used_[k] && table_.lines[k].name != "default") return &table_.lines[k];
    return nullptr;
  }

 private:
  const MaterialTable& table_;
  std::map<std::string, size_t> of_name_;
  std::vector<bool> is_used_;
};

// Returns the line that counts of two that fit a face and its surface: by the face's name, its surface's, or the later.
const Line* stronger(const Line* of_face, const std::string& face, const Line* of_surface, const std::string& surface) {
  if (!of_face || !of_surface) return of_face ? of_face : of_surface;
  if (of_face->name == face) return of_face;
  return of_surface->name == surface ? of_surface : std::max(of_face, of_surface);
}

}  // namespace

MaterialTable readMaterials(const std::filesystem::path& file) {
  MaterialTable table{file.string(), {}, {}};
  FilePlace place{file.string(), 0};
  std::error_code failure;
  if (std::filesystem::is_directory(file, failure)) place.refuse("is a directory; give a file of materials");
  std::ifstream in(file, std::ios::binary);
  if (!in) place.refuse("cannot be read; give a file of materials");
  std::vector<size_t> columns;
  std::vector<std::string> fields;
  std::map<std::string, uint32_t> lines;
  for (std::string text; std::getline(in, text);) {
    ++place.line;
    const std::string_view line = place.line == 1 ? skipByteOrderMark(text) : std::string_view(text);
    if (const size_t start = line.find_first_not_of(" \t\r"); start == std::string_view::npos || line[start] == '#')
      continue;
    if (!splitLine(line, fields)) place.refuse("a quote has no end; close it");
    if (columns.empty()) {
      columns = readHeader(fields, place);
      continue;
    }
    if (fields.size() != columns.size())
      place.refuse(fmt::format("{} fields, the header has {}; correct it", fields.size(), columns.size()));
    Fields ordered;
    for (size_t k = 0; k < fields.size(); ++k) ordered[columns[k]] = fields[k];
    const std::string& name = ordered[kSurface];
    if (name.empty()) place.refuse("the surface has no name; give one, or 'default'");
    if (name == "environment:up" || name == "environment:down")
      place.refuse(
          fmt::format("'{}': form factors have one environment, not sky and ground apart; write 'environment', "
                      "or draw sky and ground as surfaces",
                      name));
    if (name == "environment") {
      readEnvironment(ordered, place, table);
      continue;
    }
    if (const auto [earlier, is_new] = lines.try_emplace(name, place.line); !is_new)
      place.refuse(fmt::format("'{}' has a material on line {} already; remove one", printable(name), earlier->second));
    table.lines.push_back({name, readMaterial(ordered, place), place.line});
  }
  if (in.bad()) place.refuse("cannot be read to its end");
  place.line = 0;
  if (columns.empty()) place.refuse("has no header; the first line is surface,emissivity,temperature,heat_flux");
  if (table.lines.empty()) place.refuse("has no materials; give each surface a line, or one to 'default'");
  return table;
}

Enclosure assignMaterials(const MaterialTable& table, const Ids& ids, const std::vector<std::string>& surface_names) {
  LineFinder finder(table);
  const auto refuse = [&](uint32_t line, const std::string& what) { FilePlace{table.file, line}.refuse(what); };
  std::vector<const Line*> of_surface;
  of_surface.reserve(surface_names.size());
  for (const std::string& name : surface_names) of_surface.push_back(finder.find(name));
  // Empty rows have names, too.
  for (const EmptyRow& empty : ids.empty_rows) finder.find(empty.name);

  Enclosure enclosure{{}, table.environment_temperature, surface_names};
  for (uint32_t i = 0; i < ids.count(); ++i) {
    const bool has_surface = ids.surface[i] < of_surface.size();
    const Line* line =
        stronger(finder.find(ids.names[i]), ids.names[i], has_surface ? of_surface[ids.surface[i]] : nullptr,
                 has_surface ? surface_names[ids.surface[i]] : "");
    if (!line) line = finder.byDefault();
    if (!line) refuse(0, fmt::format("'{}' has no material; give it a line, or one to 'default'", ids.names[i]));
    enclosure.materials.push_back(line->material);
  }
  const bool has_temperature = std::ranges::any_of(
      enclosure.materials, [](const Material& material) { return material.temperature.has_value(); });
  if (!has_temperature && !table.environment_temperature)
    refuse(0,
           "no temperature is given to refer to, heat fluxes alone; give one surface or the environment a temperature");
  if (const Line* unused = finder.firstUnused()) {
    const bool has_wildcard = hasWildcard(unused->name);
    const bool is_face = !has_wildcard && unused->name.ends_with(']') && ids.names == surface_names;
    std::string some;
    for (size_t k = 0; k < std::min<size_t>(surface_names.size(), 5); ++k)
      some += fmt::format("{}{}", k ? ", " : "", surface_names[k]);
    refuse(unused->line, fmt::format("no surface or face {} '{}'{}; surfaces are {}{}",
                                     has_wildcard ? "fits" : "is called", printable(unused->name),
                                     is_face ? " (rows are surfaces: faces have rows with --by polygon)" : "", some,
                                     surface_names.size() > 5 ? ", ..." : ""));
  }
  return enclosure;
}

}  // namespace viewpeel
