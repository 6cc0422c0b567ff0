// A SharedEngine lets many samplers use one engine, although each sampler owns its engines.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

class SharedEngine : public Engine {
 public:
  explicit SharedEngine(Engine& engine) : engine_(engine) {}
  PairCounts count(std::span<const Direction> directions) override { return engine_.count(directions); }
  double unitArea() const override { return engine_.unitArea(); }

 private:
  Engine& engine_;
};

}  // namespace viewpeel
