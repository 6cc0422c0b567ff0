// These functions find the rows of polygons, and form factors from one surface or face to everything else.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Returns the id of each Scene::polygons entry. Checkpoints do not store these ids.
//   Throws: Error bad_usage where the ids are of another scene.    Cost: O(polygons).
std::vector<uint32_t> idsOfPolygons(const Scene& scene, const Ids& ids);

// Returns the ids of a surface or face.
//   In: name: "desk" or "desk[3]"    Out: ids, ascending
//   Throws: Error bad_usage where there is no such name, or it is only a part of a row.    Cost: O(polygons).
std::vector<uint32_t> shownIds(const Scene& scene, const Ids& ids, const std::string& name);

// Returns the form factor from all rows `from` together to each id, sum_i A_i F_ij / sum_i A_i.    Cost: O(nonzeros).
std::vector<double> formFactorsFrom(const FormFactors& form_factors, const std::vector<uint32_t>& from);

}  // namespace viewpeel
