// This file has the options and scenes of option_pairs_test, the contradictions between options, and the runs that
// cover all pairs of choices.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace viewpeel {

// An axis is an option with its choices. The first choice contradicts no choice of another axis.
struct Axis {
  std::string name;
  std::vector<std::string> choices;
};

extern const std::vector<Axis> kAxes;
constexpr size_t kOfCompute = 4;  // number of axes at the end that `plan` does not have

using Choices = std::vector<size_t>;  // for each axis the index of its choice

// `choiceOf` returns the choice of the axis with this name. `has` returns whether that choice contains `part`.
const std::string& choiceOf(const Choices& run, const std::string& axis);
bool has(const Choices& run, const std::string& axis, const std::string& part);

// Returns the messages, in part, by one of which the program may refuse the run. The list is empty where no options
// contradict each other.
std::vector<std::string> refusalsOf(const Choices& run);

// A Pair is the choice number a of axis axis_a together with the choice number b of axis axis_b.
struct Pair {
  size_t axis_a, a, axis_b, b;
  auto operator<=>(const Pair&) const = default;
};

// Returns runs of the first `axes` axes that cover all pairs of choices. A pair lies in a run without contradictions if
// there is such a run. Every other pair has one run to itself.
std::vector<Choices> coverPairs(size_t axes);

// Returns the text of an .obj file.    In: name: a choice of the axis `scene`
std::string makeScene(const std::string& name);

}  // namespace viewpeel
