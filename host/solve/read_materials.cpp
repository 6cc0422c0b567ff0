// readMaterials() reads a file of materials: docs/solve.md.
#include <viewpeel/solve.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include <fmt/format.h>

#include "io/csv.h"
#include "scene/words.h"
#include "solve/blackbody.h"
#include "solve/directional_law.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

// The first fields of a line, in the order in which they are kept. Emissivities of bands follow, shortest waves first.
enum Column { kSurface, kEmissivity, kTemperature, kHeatFlux, kDirectional, kFirstBand };
constexpr std::array<const char*, kFirstBand> kColumns{"surface", "emissivity", "temperature", "heat_flux",
                                                       "directional"};
constexpr const char* kBandPrefix = "emissivity:";
using Fields = std::vector<std::string>;

struct Header {
  std::vector<size_t> columns;    // by field of a line
  std::vector<double> limits_um;  // between bands; empty where rows are grey
  bool has_bands = false;
  static std::vector<std::string> emissivitiesOf(const Fields& fields) {
    std::vector<std::string> all{fields.begin() + kFirstBand, fields.end()};
    all.push_back(fields[kEmissivity]);
    return all;
  }
  size_t columnCount() const { return kFirstBand + (has_bands ? limits_um.size() + 1 : 0); }
};

// Reads the band in "emissivity:2.5-8" or "emissivity:8-inf".
Band readBand(const std::string& name, const FilePlace& place) {
  const std::string limits = name.substr(std::string(kBandPrefix).size());
  const size_t dash = limits.find('-');
  const std::string low = limits.substr(0, dash), high = dash == std::string::npos ? "" : limits.substr(dash + 1);
  if (low.empty() || high.empty())
    place.refuse(fmt::format("'{}' names no band; write emissivity:LOW-HIGH in micrometres, as in emissivity:2.5-8",
                             printable(name)));
  const Band band{parseFinite(low, place), high == "inf" ? INFINITY : parseFinite(high, place)};
  if (!(band.low_um >= 0 && band.low_um < band.high_um))
    place.refuse(
        fmt::format("the band '{}' does not reach from a shorter to a longer wavelength; correct it", printable(name)));
  return band;
}

// Assigns columns to bands in the order of wavelength. Refuses bands that overlap or leave a gap.
void settleBands(const std::vector<std::pair<Band, size_t>>& bands, const FilePlace& place, Header& header) {
  double end = 0;
  for (size_t found = 0; found < bands.size(); ++found) {
    const auto next = std::ranges::find_if(bands, [&](const auto& band) { return band.first.low_um == end; });
    if (next == bands.end()) break;
    header.columns[next->second] = kFirstBand + found;
    end = next->first.high_um;
    if (std::isinf(end) && found + 1 < bands.size()) break;
    if (!std::isinf(end)) header.limits_um.push_back(end);
    else return;
  }
  place.refuse(fmt::format(
      "bands of emissivity do not follow one another from 0 to inf, at {} um; give each wavelength one band", end));
}

// Reads the header: the column of each field, and the bands.
Header readHeader(const std::vector<std::string>& names, const FilePlace& place) {
  Header header;
  std::vector<std::pair<Band, size_t>> bands;
  for (const std::string& name : names) {
    const auto at = std::ranges::find(kColumns, name);
    if (at == kColumns.end() && !name.starts_with(kBandPrefix))
      place.refuse(
          fmt::format("'{}' is not a column of materials; the header is surface,emissivity,temperature,heat_flux",
                      printable(name)));
    if (at == kColumns.end()) bands.emplace_back(readBand(name, place), header.columns.size());
    header.columns.push_back(static_cast<size_t>(at - kColumns.begin()));
  }
  header.has_bands = !bands.empty();
  if (header.has_bands) settleBands(bands, place, header);
  const auto directional_columns = std::ranges::count(header.columns, size_t{kDirectional});
  if (directional_columns > 1) place.refuse("the header has the column 'directional' twice; remove one");
  if (directional_columns == 1 && header.has_bands)
    place.refuse("the header has the column 'directional' beside columns of bands; leave one of the two out");
  for (size_t k = 0; k < kDirectional; ++k) {
    const bool is_absent = header.has_bands && k == kEmissivity;
    if (std::ranges::count(header.columns, k) == (is_absent ? 0 : 1)) continue;
    place.refuse(is_absent ? "the header has the column 'emissivity' beside columns of bands; remove it"
                           : fmt::format("the header needs the column '{}' once: surface,emissivity,temperature,"
                                         "heat_flux",
                                         kColumns[k]));
  }
  return header;
}

double readEmissivity(const std::string& field, const FilePlace& place) {
  const double emissivity = parseFinite(field, place);
  if (!(emissivity > 0 && emissivity <= 1))
    place.refuse(fmt::format("an emissivity of {} is not above 0 and up to 1; correct it", field));
  return emissivity;
}

double readTemperature(const std::string& field, const FilePlace& place) {
  const double temperature = parseFinite(field, place);
  if (temperature < 0) place.refuse(fmt::format("a temperature of {} K is below 0; give kelvins", field));
  return temperature;
}

// Laws reads directional laws, each once, by the text that names them.
class Laws {
 public:
  // Returns the index of a law, or nothing where the text is empty.
  //   In: text: `cosine:POWER`, or the name of a table, beside the materials    Throws: Error bad_input.
  std::optional<uint32_t> find(const std::string& text, const FilePlace& place) {
    if (text.empty()) return {};
    const auto [law, is_new] = index_of_.try_emplace(text, static_cast<uint32_t>(laws.size()));
    if (!is_new) return law->second;
    if (text.starts_with(kCosine)) {
      laws.push_back({.cosine_power = parseFinite(std::string_view(text).substr(kCosine.size()), place)});
      if (const std::string fault = findFault(laws.back()); !fault.empty()) place.refuse(fault);
    } else {
      laws.push_back(readDirectionalLaw((std::filesystem::path(place.file).parent_path() / text).string()));
    }
    return law->second;
  }

  std::vector<DirectionalLaw> laws;

 private:
  static constexpr std::string_view kCosine = "cosine:";
  std::map<std::string, uint32_t> index_of_;
};

Material readMaterial(const Fields& fields, const FilePlace& place, Laws& laws) {
  Material material;
  for (size_t k = kFirstBand; k < fields.size(); ++k)
    material.band_emissivities.push_back(readEmissivity(fields[k], place));
  if (material.band_emissivities.size() == 1) {  // one band is all wavelengths
    material.emissivity = material.band_emissivities.front();
    material.band_emissivities.clear();
  } else if (material.band_emissivities.empty()) material.emissivity = readEmissivity(fields[kEmissivity], place);
  if (fields[kTemperature].empty() == fields[kHeatFlux].empty())
    place.refuse(fmt::format("'{}' has {} temperature {} heat_flux; give one of the two", printable(fields[kSurface]),
                             fields[kTemperature].empty() ? "neither" : "both",
                             fields[kTemperature].empty() ? "nor" : "and"));
  if (!fields[kTemperature].empty()) material.temperature = readTemperature(fields[kTemperature], place);
  else material.heat_flux = fields[kHeatFlux] == "adiabatic" ? 0 : parseFinite(fields[kHeatFlux], place);
  material.directional = laws.find(fields[kDirectional], place);
  if (material.directional)
    if (const std::string excess = findExcess(material.emissivity, laws.laws[*material.directional]); !excess.empty())
      place.refuse(excess);
  return material;
}

constexpr const char* kAbove = "environment:up";
constexpr const char* kBelow = "environment:down";

// EnvironmentLines hold the temperatures on the lines `environment`, `environment:up` and `environment:down`.
struct EnvironmentLines {
  std::optional<double> whole, up, down;
  std::optional<double>* find(const std::string& name) {
    return name == "environment" ? &whole : name == kAbove ? &up : name == kBelow ? &down : nullptr;
  }
};

double readEnvironment(const Fields& fields, const FilePlace& place, const std::optional<double>& earlier) {
  const std::string& name = fields[kSurface];
  if (earlier) place.refuse(fmt::format("'{}' has a line already; remove one", name));
  const bool is_black = std::ranges::all_of(Header::emissivitiesOf(fields), [&](const std::string& field) {
    return field.empty() || parseFinite(field, place) == 1;
  });
  if (!is_black || fields[kTemperature].empty() || !fields[kHeatFlux].empty() || !fields[kDirectional].empty())
    place.refuse(fmt::format("'{0}' is black and has a temperature alone; write {0},,KELVIN,", name));
  return readTemperature(fields[kTemperature], place);
}

// Sets the environment's temperatures. Where only one part has a line, `environment` gives the other part's.
void settleEnvironment(const EnvironmentLines& lines, const FilePlace& place, MaterialTable& table) {
  if (!lines.up && !lines.down) {
    table.environment_temperature = lines.whole;
    return;
  }
  if (lines.up && lines.down && lines.whole)
    place.refuse(fmt::format("'{}' and '{}' leave nothing to 'environment'; remove one of the three", kAbove, kBelow));
  const std::optional<double> up = lines.up ? lines.up : lines.whole, down = lines.down ? lines.down : lines.whole;
  if (!up || !down)
    place.refuse(fmt::format("'{}' has a temperature and '{}' none; give it a line, or one to 'environment'",
                             up ? kAbove : kBelow, up ? kBelow : kAbove));
  table.sky_and_ground = {*up, *down};
}

}  // namespace

MaterialTable readMaterials(const std::filesystem::path& file) {
  MaterialTable table{.file = file.string(), .lines = {}, .environment_temperature = {}};
  FilePlace place{file.string(), 0};
  std::error_code failure;
  if (std::filesystem::is_directory(file, failure)) place.refuse("is a directory; give a file of materials");
  std::ifstream in(file, std::ios::binary);
  if (!in) place.refuse("cannot be read; give a file of materials");
  Header header;
  std::vector<std::string> fields;
  std::map<std::string, uint32_t> lines;
  EnvironmentLines environment;
  Laws laws;
  for (std::string text; std::getline(in, text);) {
    ++place.line;
    const std::string_view line = place.line == 1 ? skipByteOrderMark(text) : std::string_view(text);
    if (const size_t start = line.find_first_not_of(" \t\r"); start == std::string_view::npos || line[start] == '#')
      continue;
    if (!splitLine(line, fields)) place.refuse("a quote has no end; close it");
    if (header.columns.empty()) {
      header = readHeader(fields, place);
      continue;
    }
    if (fields.size() != header.columns.size())
      place.refuse(fmt::format("{} fields, the header has {}; correct it", fields.size(), header.columns.size()));
    Fields ordered(header.columnCount());
    for (size_t k = 0; k < fields.size(); ++k) ordered[header.columns[k]] = fields[k];
    const std::string& name = ordered[kSurface];
    if (name.empty()) place.refuse("the surface has no name; give one, or 'default'");
    if (std::optional<double>* const part = environment.find(name)) {
      *part = readEnvironment(ordered, place, *part);
      continue;
    }
    if (const auto [earlier, is_new] = lines.try_emplace(name, place.line); !is_new)
      place.refuse(fmt::format("'{}' has a material on line {} already; remove one", printable(name), earlier->second));
    table.lines.push_back({name, readMaterial(ordered, place, laws), place.line});
  }
  if (in.bad()) place.refuse("cannot be read to its end");
  place.line = 0;
  if (header.columns.empty()) place.refuse("has no header; the first line is surface,emissivity,temperature,heat_flux");
  table.band_limits_um = header.limits_um;
  table.laws = std::move(laws.laws);
  settleEnvironment(environment, place, table);
  if (table.lines.empty()) place.refuse("has no materials; give each surface a line, or one to 'default'");
  return table;
}

}  // namespace viewpeel
