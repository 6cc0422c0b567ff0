#include <viewpeel/solve.h>

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "io/csv.h"
#include "scene/face_names.h"
#include "scene/words.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Line = MaterialTable::Line;

// Returns whether a text matches a pattern, in which * stands for any characters and ? for one.
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

// A LineFinder finds the lines of a table that match a name, and remembers which lines have been used.
class LineFinder {
 public:
  explicit LineFinder(const MaterialTable& table) : table_(table), is_used_(table.lines.size()) {
    for (size_t k = 0; k < table.lines.size(); ++k) of_name_[table.lines[k].name] = k;
  }

  // Returns the line with exactly this name, else the last line whose wildcards match. Marks matching lines as
  // used.
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

// Returns which of two lines counts for a face: the line with the face's name, else with its surface's name, else the
// later line, both of which have wildcards.
const Line* stronger(const Line* of_face, const std::string& face, const Line* of_surface, const std::string& surface) {
  if (!of_face || !of_surface) return of_face ? of_face : of_surface;
  if (of_face->name == face) return of_face;
  return of_surface->name == surface ? of_surface : std::max(of_face, of_surface);
}

}  // namespace

Enclosure assignMaterials(const MaterialTable& table, const Ids& ids, const std::vector<std::string>& surface_names) {
  LineFinder finder(table);
  const auto refuse = [&](uint32_t line, const std::string& what) { FilePlace{table.file, line}.refuse(what); };
  std::vector<const Line*> of_surface;
  of_surface.reserve(surface_names.size());
  for (const std::string& name : surface_names) of_surface.push_back(finder.find(name));
  // Lines may name empty rows, too, so that these lines count as used.
  for (const EmptyRow& empty : ids.empty_rows) finder.find(empty.name);

  Enclosure enclosure{.materials = {},
                      .environment_temperature = table.environment_temperature,
                      .surface_names = surface_names,
                      .sky_and_ground = table.sky_and_ground,
                      .band_limits_um = table.band_limits_um,
                      .laws = table.laws};
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
  if (!has_temperature && !table.environment_temperature && !table.sky_and_ground)
    refuse(0,
           "no temperature is given to refer to, heat fluxes alone; give one surface or the environment a temperature");
  if (const Line* unused = finder.firstUnused()) {
    const bool has_wildcard = hasWildcard(unused->name);
    const bool is_face = !has_wildcard && unused->name.ends_with(']') && ids.names == surface_names;
    refuse(unused->line,
           fmt::format("no surface or face {} '{}'{}; {}", has_wildcard ? "fits" : "is called", printable(unused->name),
                       is_face ? " (rows are surfaces: faces have rows with --by polygon)" : "",
                       explainUnknownName(unused->name, surface_names, {})));
  }
  return enclosure;
}

}  // namespace viewpeel
