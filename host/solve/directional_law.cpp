#include "solve/directional_law.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <fmt/format.h>

#include "io/csv.h"
#include "scene/words.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr double kDegree = std::numbers::pi / 180, kEmissivityRounding = 1e-12;
constexpr const char* kHeader = "angle_degrees,relative_emissivity";

// Returns the integral of g sin(2 angle) over all angles, the mean of g weighted by the cosine: eq. (57). g is linear
// between the angles of the table, and each piece is exact: int (a + b x) sin 2x dx = -(a + b x) cos(2x) / 2 +
// b sin(2x) / 4.
double meanOfTable(const DirectionalLaw& law) {
  double mean = 0;
  for (size_t k = 0; k + 1 < law.values.size(); ++k) {
    const double from = law.angles_deg[k] * kDegree, to = law.angles_deg[k + 1] * kDegree;
    const double slope = (law.values[k + 1] - law.values[k]) / (to - from);
    mean += (law.values[k] * std::cos(2 * from) - law.values[k + 1] * std::cos(2 * to)) / 2 +
            slope * (std::sin(2 * to) - std::sin(2 * from)) / 4;
  }
  return mean;
}

}  // namespace

RelativeEmissivity::RelativeEmissivity(const DirectionalLaw& law) : law_(law) {
  if (law.values.empty()) {
    // int_0^1 2 mu^(p + 1) dmu = 2 / (p + 2)
    scale_ = largest_ = (law.cosine_power + 2) / 2;
    is_constant_ = law.cosine_power == 0;
    return;
  }
  scale_ = 1 / meanOfTable(law);
  const auto [least, most] = std::ranges::minmax(law.values);
  largest_ = most * scale_;
  is_constant_ = least == most;
}

double RelativeEmissivity::at(double cosine) const {
  if (is_constant_) return 1;
  if (law_.values.empty()) return scale_ * std::pow(cosine, law_.cosine_power);
  const double angle = std::acos(std::clamp(cosine, 0.0, 1.0)) / kDegree;
  const auto after = std::upper_bound(law_.angles_deg.begin() + 1, law_.angles_deg.end() - 1, angle);
  const auto k = static_cast<size_t>(after - law_.angles_deg.begin());
  const double from = law_.angles_deg[k - 1], share = (angle - from) / (law_.angles_deg[k] - from);
  return scale_ * std::lerp(law_.values[k - 1], law_.values[k], std::clamp(share, 0.0, 1.0));
}

std::string findFault(const DirectionalLaw& law) {
  if (law.values.size() != law.angles_deg.size()) return "a value is needed for each angle; give as many of both";
  if (law.values.empty())
    return law.cosine_power >= 0 && std::isfinite(law.cosine_power)
               ? ""
               : fmt::format("a power of {} is not a number from 0 on; correct it", law.cosine_power);
  const std::vector<double>& angles = law.angles_deg;
  if (angles.size() < 2 || angles.front() != 0 || angles.back() != 90)
    return "angles do not reach from 0 to 90 degrees; give both ends a value";
  for (size_t k = 1; k < angles.size(); ++k)
    if (!(angles[k] > angles[k - 1])) return fmt::format("the angle {} does not ascend; sort the angles", angles[k]);
  if (std::ranges::any_of(law.values, [](double value) { return !(value >= 0 && std::isfinite(value)); }))
    return "a relative emissivity is not a number from 0 on; correct it";
  return meanOfTable(law) > 0 ? "" : "all relative emissivities are 0; give one above 0";
}

std::string findExcess(double emissivity, const DirectionalLaw& law) {
  const double largest = RelativeEmissivity(law).largest();
  if (emissivity * largest <= 1 + kEmissivityRounding) return "";
  return fmt::format(
      "a hemispherical emissivity of {} would be {:.4g} at the angle of most emission, above 1; give "
      "{:.6g} at most, or another directional law",
      emissivity, emissivity * largest, std::floor(1e6 / largest) / 1e6);
}

void requireDiffuse(const Enclosure& enclosure) {
  if (std::ranges::any_of(enclosure.materials,
                          [](const Material& material) { return material.directional.has_value(); }))
    throw Error(ErrorCode::bad_usage,
                "form factors are of diffuse surfaces, and a material depends on the angle; solve the scene without a "
                "matrix, or leave out directional");
}

DirectionalLaw readDirectionalLaw(const std::string& file) {
  FilePlace place{file, 0};
  std::error_code failure;
  std::ifstream in;
  if (std::filesystem::is_regular_file(file, failure)) in.open(file, std::ios::binary);
  if (!in.is_open()) place.refuse(fmt::format("cannot be read; write cosine:POWER, or name a .csv with {}", kHeader));
  DirectionalLaw law;
  std::vector<std::string> fields;
  bool has_header = false;
  for (std::string text; std::getline(in, text);) {
    ++place.line;
    const std::string_view line = place.line == 1 ? skipByteOrderMark(text) : std::string_view(text);
    if (const size_t start = line.find_first_not_of(" \t\r"); start == std::string_view::npos || line[start] == '#')
      continue;
    if (!splitLine(line, fields) || fields.size() != 2) place.refuse("a line has an angle and a value; correct it");
    if (!has_header) {
      if (fmt::format("{},{}", fields[0], fields[1]) != kHeader)
        place.refuse(fmt::format("the header is not {}; correct it", kHeader));
      has_header = true;
      continue;
    }
    law.angles_deg.push_back(parseFinite(fields[0], place));
    law.values.push_back(parseFinite(fields[1], place));
  }
  place.line = 0;
  if (in.bad()) place.refuse("cannot be read to its end");
  if (law.values.empty()) place.refuse(fmt::format("has no values; the first line is {}", kHeader));
  if (const std::string fault = findFault(law); !fault.empty()) place.refuse(fault);
  return law;
}

}  // namespace viewpeel
