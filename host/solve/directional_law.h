// A RelativeEmissivity evaluates a DirectionalLaw: docs/method.md, eq. (57).
#pragma once
#include <string>
#include <vector>

#include <viewpeel/solve.h>

namespace viewpeel {

class RelativeEmissivity {
 public:
  //   In: law: kept by reference, and sound: findFault(law) is empty
  explicit RelativeEmissivity(const DirectionalLaw& law);

  // Returns the emissivity g at an angle relative to the hemispherical one.    In: cosine: of the angle, in [0, 1]
  //   Out: g, whose mean over the hemisphere, weighted by the cosine, is 1
  //   Error: rounding. Tests: tests/unit/directional_law_test.cpp.    Cost: O(log (angles of the table)).
  double at(double cosine) const;
  double largest() const { return largest_; }
  bool isConstant() const { return is_constant_; }

 private:
  const DirectionalLaw& law_;
  double scale_ = 1, largest_ = 1;
  bool is_constant_ = true;
};

// Returns what is wrong with a law, with the remedy; empty where nothing is.
std::string findFault(const DirectionalLaw& law);

// Returns what is wrong with a hemispherical emissivity beside a sound law: an emissivity above 1 at some angle. Empty
// where nothing is.
std::string findExcess(double emissivity, const DirectionalLaw& law);

// Refuses directional materials where form factors are given, which are of diffuse rows.    Throws: Error bad_usage.
void requireDiffuse(const Enclosure& enclosure);

// Reads a table of relative emissivities, .csv with the header `angle_degrees,relative_emissivity`.
//   Out: a sound law    Throws: Error bad_input, naming file, line and remedy.    Cost: O(length of the file).
DirectionalLaw readDirectionalLaw(const std::string& file);

}  // namespace viewpeel
