// A truth is a scene's form factors from a run that is much finer than the runs that are judged by it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/compute.h>

namespace viewpeel::bench {

// These scenes have truths.
const std::vector<std::string>& judgedScenes();
// Returns a scene by its name, of judgedScenes().
Scene makeJudgedScene(const std::string& name);

// Returns the request of an estimate to a tolerance, as users make it.    In: scene: its name
Request requestFor(const std::string& scene, double tolerance, uint64_t seed);

// Returns the form factors to a tolerance, of a seed that no judged run has. Of scenes beyond 8,000 polygons they have
// 48 rows, and only the entries of these rows are judged.
FormFactors computeTruth(const Scene& scene, const std::string& name, double tolerance);

// Returns the largest standard error of all entries, from the row with the smaller area.
double largestErrorOf(const FormFactors& truth);

struct Comparison {
  double largest = 0;                // largest error of a form factor, from the row with the smaller area
  double largest_of_sums = 0;        // largest error of the sum of a row's form factors, without environment and leak
  uint64_t entries = 0, beyond = 0;  // entries with a standard error; and the entries off by more than 5 of both errors
};

// Compares the entries of all rows that the truth has, environment and leak among them.
Comparison compare(const FormFactors& found, const FormFactors& truth);

}  // namespace viewpeel::bench
