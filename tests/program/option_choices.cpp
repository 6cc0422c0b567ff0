#include "tests/program/option_choices.h"

#include <algorithm>
#include <array>
#include <functional>
#include <set>
#include <sstream>

#include <fmt/format.h>

namespace viewpeel {
namespace {

struct Box {
  std::array<double, 3> low, high;
  bool inward = false;
};

// Writes the six faces of a box, in the order x0, x1, y0, y1, z0, z1. A face with an empty name is left out.
void addBox(std::ostream& obj, int& corners, const std::array<std::string, 6>& names, const Box& box) {
  for (int k = 0; k < 8; ++k)
    obj << fmt::format("v {} {} {}\n", k & 1 ? box.high[0] : box.low[0], k & 2 ? box.high[1] : box.low[1],
                       k & 4 ? box.high[2] : box.low[2]);
  const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};  // fronts look outward
  for (int f = 0; f < 6; ++f) {
    if (names[f].empty()) continue;
    obj << "o " << names[f] << "\nf";
    for (int k = 0; k < 4; ++k) obj << ' ' << corners + 1 + faces[f][box.inward ? 3 - k : k];
    obj << '\n';
  }
  corners += 8;
}

void addQuad(std::ostream& obj, int& corners, const std::string& name, const std::array<std::array<double, 3>, 4>& at) {
  for (const auto& c : at) obj << fmt::format("v {} {} {}\n", c[0], c[1], c[2]);
  obj << fmt::format("o {}\nf {} {} {} {}\n", name, corners + 1, corners + 2, corners + 3, corners + 4);
  corners += 4;
}

const std::array<std::string, 6> kRoom = {"west", "east", "south", "north", "floor", "ceiling"};

bool isOpen(const std::string& scene) { return scene == "plates" || scene == "sliver"; }

// Returns whether pair lines give the guarantee. They do unless an option requires directions.
bool isByLines(const Choices& run) {
  return has(run, "goal", "--epsilon 0.2") && choiceOf(run, "sampler").empty() && choiceOf(run, "sampling").empty() &&
         choiceOf(run, "unoccluded").empty() && !has(run, "engine", "exact");
}

struct Contradiction {
  std::function<bool(const Choices&)> holds;
  std::string says;  // a part of the message, which names the option to change
};

const std::vector<Contradiction> kContradictions = {
    {[](const Choices& r) { return has(r, "balance", "--balance") && has(r, "question", "-"); },
     "--balance needs every row"},
    {[](const Choices& r) {
       return has(r, "balance", "--balance") && (isOpen(choiceOf(r, "scene")) || has(r, "sides", "two"));
     },
     "balance: "},
    {[](const Choices& r) {
       return has(r, "unoccluded", "on") &&
              (has(r, "engine", "graphics") || has(r, "engine", "exact") || has(r, "question", "-"));
     },
     "--unoccluded on needs the whole matrix and --engine compute or host"},
    {[](const Choices& r) {
       return has(r, "unoccluded", "on") && has(r, "goal", "epsilon") &&
              (has(r, "by", "surface") || has(r, "goal", "median"));
     },
     "of a guarantee also --by polygon and --statistic mean"},
    {[](const Choices& r) { return has(r, "question", "-") && has(r, "engine", "graphics"); },
     "--from, --pair and --blocker need --engine compute, host or exact"},
    {[](const Choices& r) {
       return has(r, "sampling", "scanline") && (has(r, "engine", "graphics") || has(r, "engine", "exact"));
     },
     "--sampling scanline needs --engine compute or host"},
    {[](const Choices& r) {
       return has(r, "goal", "finest") && (has(r, "engine", "graphics") || has(r, "question", "-"));
     },
     "--finest needs --engine compute or host and the whole matrix"},
    {[](const Choices& r) { return has(r, "goal", "resolution") && has(r, "engine", "exact"); },
     "--engine exact has no lattice; leave out --resolution"},
    {[](const Choices& r) {
       return has(r, "goal", "--epsilon 0.2") && (has(r, "sampler", "fibonacci") || has(r, "sampler", "sobol"));
     },
     "a guarantee needs independent directions: --sampler jittered or iid"},
    {[](const Choices& r) {
       return has(r, "goal", "median") && has(r, "sampler", "--sampler") && !has(r, "sampler", "iid");
     },
     "the median needs independent runs of independent directions: --sampler iid"},
    {[](const Choices& r) { return has(r, "goal", "--rms") && (has(r, "by", "surface") || has(r, "question", "-")); },
     "--rms is over all polygons"},
    {[](const Choices& r) { return has(r, "goal", "median") && has(r, "long run", "checkpoint"); },
     "--checkpoint keeps means only; leave out --statistic median"},
    {[](const Choices& r) { return isByLines(r) && has(r, "long run", "checkpoint"); },
     "--checkpoint keeps a guarantee by common directions only"},
};

}  // namespace

const std::vector<Axis> kAxes = {
    {"goal",
     {"--directions 60 --replicates 16", "--tolerance 0.01 --replicates 16", "--relative 0.1 --replicates 16",
      "--seconds 0.3", "--epsilon 0.2 --delta 1e-6 --rows", "--epsilon 0.5 --delta 1e-3 --statistic median",
      "--directions 60 --replicates 16 --resolution 96", "--directions 60 --replicates 16 --resolution 24 --finest 96",
      "--rms 0.01 --replicates 16"}},
    {"scene", {"cube", "plates", "box", "wall", "sliver", "junctions"}},
    {"engine", {"", "--engine auto", "--engine compute", "--engine host", "--engine graphics", "--engine exact"}},
    {"by", {"", "--by polygon", "--by surface"}},
    {"unoccluded", {"", "--unoccluded off", "--unoccluded on"}},
    {"sampling", {"", "--sampling lattice", "--sampling scanline"}},
    {"sampler", {"", "--sampler fibonacci", "--sampler jittered", "--sampler sobol", "--sampler iid"}},
    {"sides", {"", "--two-sided"}},
    {"question", {"", "--from floor", "--pair floor ceiling", "--blocker ceiling"}},
    {"balance", {"", "--balance"}},
    {"long run", {"", "--checkpoint", "--checkpoint --resume"}},
    {"matrix", {"", "-o"}},  // beside the .csv file
    {"talk", {"", "--quiet", "--verbose", "--json"}},
};

const std::string& choiceOf(const Choices& run, const std::string& axis) {
  const auto at = std::find_if(kAxes.begin(), kAxes.end(), [&](const Axis& a) { return a.name == axis; });
  return at->choices[run[static_cast<size_t>(at - kAxes.begin())]];
}

bool has(const Choices& run, const std::string& axis, const std::string& part) {
  return choiceOf(run, axis).find(part) != std::string::npos;
}

std::vector<std::string> refusalsOf(const Choices& run) {
  std::vector<std::string> says;
  for (const Contradiction& c : kContradictions)
    if (c.holds(run)) says.push_back(c.says);
  return says;
}

std::vector<Choices> coverPairs(size_t axes) {
  std::set<Pair> left;
  std::vector<Choices> runs;
  const Choices plain(kAxes.size(), 0);
  for (size_t i = 0; i < axes; ++i)
    for (size_t j = i + 1; j < axes; ++j)
      for (size_t a = 0; a < kAxes[i].choices.size(); ++a)
        for (size_t b = 0; b < kAxes[j].choices.size(); ++b) {
          Choices run = plain;
          run[i] = a, run[j] = b;
          if (refusalsOf(run).empty()) left.insert({i, a, j, b});
          else runs.push_back(run);
        }
  while (!left.empty()) {
    const Pair first = *left.begin();
    Choices run = plain;
    run[first.axis_a] = first.a, run[first.axis_b] = first.b;
    std::vector<size_t> chosen = {first.axis_a, first.axis_b};
    for (size_t axis = 0; axis < axes; ++axis) {
      if (axis == first.axis_a || axis == first.axis_b) continue;
      size_t best = 0;
      int most = -1;
      for (size_t choice = 0; choice < kAxes[axis].choices.size(); ++choice) {
        run[axis] = choice;
        if (!refusalsOf(run).empty()) continue;
        int gained = 0;
        for (size_t other : chosen)
          gained += left.contains(axis < other ? Pair{axis, choice, other, run[other]}
                                               : Pair{other, run[other], axis, choice});
        if (gained > most) best = choice, most = gained;
      }
      run[axis] = best;
      chosen.push_back(axis);
    }
    for (size_t i = 0; i < axes; ++i)
      for (size_t j = i + 1; j < axes; ++j) left.erase({i, run[i], j, run[j]});
    runs.push_back(run);
  }
  return runs;
}

std::string makeScene(const std::string& name) {
  std::ostringstream obj;
  int corners = 0;
  const auto addRoom = [&](std::array<std::string, 6> names = kRoom) {
    addBox(obj, corners, names, {{0, 0, 0}, {1, 1, 1}, true});
  };
  if (name == "cube") addRoom();
  if (name == "plates") {
    addQuad(obj, corners, "floor", {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
    addQuad(obj, corners, "ceiling", {{{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}}});
  }
  if (name == "box") {  // the box stands on the floor
    addRoom();
    addBox(obj, corners, {"box", "box", "box", "box", "box", "box"}, {{0.3, 0.2, 0}, {0.7, 0.5, 0.4}});
  }
  if (name == "wall") {  // the wall has two coincident faces, and divides the room in two
    addRoom();
    addQuad(obj, corners, "partition_west", {{{0.4, 0, 0}, {0.4, 0, 1}, {0.4, 1, 1}, {0.4, 1, 0}}});
    addQuad(obj, corners, "partition_east", {{{0.4, 0, 0}, {0.4, 1, 0}, {0.4, 1, 1}, {0.4, 0, 1}}});
  }
  if (name == "sliver") {
    addQuad(obj, corners, "floor", {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
    addQuad(obj, corners, "ceiling", {{{0, 0.4995, 0.5}, {0, 0.5005, 0.5}, {1, 0.5005, 0.5}, {1, 0.4995, 0.5}}});
  }
  if (name == "junctions") {  // two polygons of the floor meet a third in the middle of its edge
    addRoom({"west", "east", "south", "north", "", "ceiling"});
    addQuad(obj, corners, "floor", {{{0, 0, 0}, {0.5, 0, 0}, {0.5, 1, 0}, {0, 1, 0}}});
    addQuad(obj, corners, "floor", {{{0.5, 0, 0}, {1, 0, 0}, {1, 0.5, 0}, {0.5, 0.5, 0}}});
    addQuad(obj, corners, "floor", {{{0.5, 0.5, 0}, {1, 0.5, 0}, {1, 1, 0}, {0.5, 1, 0}}});
  }
  return obj.str();
}

}  // namespace viewpeel
