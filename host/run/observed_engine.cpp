#include "run/observed_engine.h"

namespace viewpeel {
namespace {

class ObservedEngine final : public Engine {
 public:
  ObservedEngine(std::unique_ptr<Engine> engine, std::function<void(bool)> on_count)
      : engine_(std::move(engine)), on_count_(std::move(on_count)) {}

  PairCounts count(std::span<const Direction> directions) override {
    const Call call(on_count_);
    return engine_->count(directions);
  }
  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override {
    const Call call(on_count_);
    return engine_->countBlocks(directions, block_directions);
  }
  double unitArea() const override { return engine_->unitArea(); }
  const Work* work() const override { return engine_->work(); }
  std::string describePlan() const override { return engine_->describePlan(); }

 private:
  // The observer is notified at the end even of a call that throws.
  struct Call {
    explicit Call(const std::function<void(bool)>& on_count) : on_count_(on_count) { on_count_(true); }
    ~Call() { on_count_(false); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;
    const std::function<void(bool)>& on_count_;
  };

  std::unique_ptr<Engine> engine_;
  std::function<void(bool)> on_count_;
};

}  // namespace

std::unique_ptr<Engine> observed(std::unique_ptr<Engine> engine, std::function<void(bool)> on_count) {
  if (!on_count) return engine;
  return std::make_unique<ObservedEngine>(std::move(engine), std::move(on_count));
}

}  // namespace viewpeel
