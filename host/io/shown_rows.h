// Which rows polygons belong to, and the form factors from one surface or face to everything else.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Returns the id of each Scene::polygons entry, which ids of a checkpoint do not keep.
//   Throws: Error bad_usage where the ids are of another scene.    Cost: O(polygons).
std::vector<uint32_t> idsOfPolygons(const Scene& scene, const Ids& ids);

// Returns the ids of a surface or face.
//   In: name: "desk" or "desk[3]"    Out: ids, ascending
//   Throws: Error bad_usage where there is none, or where it is a part of a row.    Cost: O(polygons).
std::vector<uint32_t> shownIds(const Scene& scene, const Ids& ids, const std::string& name);

// Returns the form factor from all of `from` together to every id, sum_i A_i F_ij / sum_i A_i.    Cost: O(nonzeros).
std::vector<double> formFactorsFrom(const FormFactors& form_factors, const std::vector<uint32_t>& from);

}  // namespace viewpeel
