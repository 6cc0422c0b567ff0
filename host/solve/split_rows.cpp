#include "solve/split_rows.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "solve/directional_law.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

// The DirectionalPolygons of a scene give the emissivity of each along a direction.
class DirectionalPolygons {
 public:
  DirectionalPolygons(const Scene& scene, const Ids& ids, const Enclosure& enclosure)
      : of_polygon_(ids.of_polygon), materials_(enclosure.materials), laws_(enclosure.laws) {
    for (const DirectionalLaw& law : laws_) factors_.emplace_back(law);
    for (const Polygon& polygon : scene.polygons) normals_.push_back(frontNormal(scene, polygon));
  }

  double emissivity(uint32_t polygon, const glm::dvec3& u) const {
    const Material& material = materials_[of_polygon_[polygon]];
    const double cosine = std::abs(glm::dot(normals_[polygon], u));
    return std::min(1.0, material.emissivity * factors_[*material.directional].at(cosine));
  }

 private:
  std::vector<uint32_t> of_polygon_;
  std::vector<Material> materials_;
  std::vector<DirectionalLaw> laws_;
  std::vector<RelativeEmissivity> factors_;
  std::vector<glm::dvec3> normals_;
};

// Returns whether a row's emissivity depends on the angle.
bool isDirectional(const Material& material, const Enclosure& enclosure, const std::string& name) {
  if (!material.directional) return false;
  const auto refuse = [&](const std::string& what) {
    if (!what.empty()) throw Error(ErrorCode::bad_usage, fmt::format("'{}': {}", name, what));
  };
  if (*material.directional >= enclosure.laws.size()) refuse("has no directional law; give Enclosure::laws");
  const DirectionalLaw& law = enclosure.laws[*material.directional];
  refuse(findFault(law));
  refuse(findExcess(material.emissivity, law));
  return !RelativeEmissivity(law).isConstant() && material.emissivity < 1;
}

}  // namespace

SplitRows splitRows(const Scene& scene, const Ids& ids, const Enclosure& enclosure) {
  SplitRows split{.ids = ids, .enclosure = enclosure, .answers = answerRows(ids, enclosure), .shares = {}};
  PolygonShares shares{.two_sided = ids.two_sided};
  std::vector<PolygonShares::Rows> rows_of_id;
  for (uint32_t i = 0; i < ids.count(); ++i) {
    PolygonShares::Rows& rows = rows_of_id.emplace_back(PolygonShares::Rows{i, PolygonShares::kNone});
    const Material& material = enclosure.materials[i];
    if (!isDirectional(material, enclosure, ids.names[i])) continue;
    rows.second = split.ids.count();
    split.answers.rows[i].push_back(rows.second);
    if (ids.surface[i] < split.answers.surfaces.size()) split.answers.surfaces[ids.surface[i]].push_back(rows.second);
    split.ids.names.push_back(ids.names[i]);
    split.ids.surface.push_back(ids.surface[i]);
    split.ids.areas.push_back((1 - material.emissivity) * ids.areas[i]);
    split.ids.areas[i] *= material.emissivity;
    Material& emitter = split.enclosure.materials[i];
    emitter.emissivity = 1;
    if (emitter.heat_flux) *emitter.heat_flux /= material.emissivity;
    Material& reflector = split.enclosure.materials.emplace_back();
    reflector.emissivity = 0;
    reflector.heat_flux = 0;
  }
  if (split.ids.count() == ids.count()) return split;
  for (const uint32_t id : ids.of_polygon) shares.rows.push_back(rows_of_id[id]);
  shares.row_count = split.ids.count();
  const auto polygons = std::make_shared<const DirectionalPolygons>(scene, ids, enclosure);
  shares.share_of_first = [polygons](uint32_t polygon, const glm::dvec3& u) {
    return polygons->emissivity(polygon, u);
  };
  split.shares = std::move(shares);
  return split;
}

}  // namespace viewpeel
