// Lists options and scenes of option_pairs_test, and which choices contradict each other; makes runs of all pairs of
// choices.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace viewpeel {

// The first choice of every option contradicts no choice of another.
struct Axis {
  std::string name;
  std::vector<std::string> choices;
};

extern const std::vector<Axis> kAxes;
constexpr size_t kOfCompute = 4;  // the last, which `plan` does not have

using Choices = std::vector<size_t>;  // a choice of every axis

// Returns the choice of an axis by its name, and whether it has this part.
const std::string& choiceOf(const Choices& run, const std::string& axis);
bool has(const Choices& run, const std::string& axis, const std::string& part);

// Returns a part of each line that may refuse the run, for it contradicts itself: none for most.
std::vector<std::string> refusalsOf(const Choices& run);

struct Pair {
  size_t axis_a, a, axis_b, b;
  auto operator<=>(const Pair&) const = default;
};

// Returns runs of the first `axes` axes. Runs without contradictions hold every pair of choices which has such a run;
// every other pair has one run.
std::vector<Choices> coverPairs(size_t axes);

// Returns the text of an .obj file.    In: name: a choice of the axis `scene`
std::string makeScene(const std::string& name);

}  // namespace viewpeel
