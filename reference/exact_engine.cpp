#include "reference/exact_engine.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <thread>

#include "error.h"
#include "reference/exact_pair_areas.h"

namespace viewpeel::reference {
namespace {

constexpr double kUnit = 0x1p-40;

class ExactEngine : public Engine {
 public:
  ExactEngine(const Scene& scene, const Ids& ids, unsigned thread_count)
      : scene_(scene), ids_(ids), thread_count_(thread_count ? thread_count : std::max(1u, std::thread::hardware_concurrency())) {
    if (const auto found = findInterpenetrations(scene); !found.empty()) throw Error(ErrorCode::bad_input, describe(scene, found.front()));
  }

  PairCounts count(std::span<const Direction> directions) override {
    std::map<std::pair<uint32_t, uint32_t>, uint64_t> sums;
    std::mutex guard;
    std::exception_ptr failure;
    std::atomic<size_t> next = 0;
    const auto work = [&] {
      try {
        for (size_t k = next++; k < directions.size(); k = next++) {
          const PairAreas areas = computePairAreas(scene_, directions[k].u, {.two_sided = ids_.two_sided});
          const std::lock_guard lock(guard);
          for (const PairArea& pair : areas.pairs) {
            const uint32_t i = ids_.of_polygon[pair.a], j = pair.b < kEnvironment ? ids_.of_polygon[pair.b] : pair.b;
            sums[{std::min(i, j), std::max(i, j)}] += static_cast<uint64_t>(std::llround(pair.area / kUnit));
          }
        }
      } catch (...) {
        const std::lock_guard lock(guard);
        failure = std::current_exception();
      }
    };
    std::vector<std::thread> threads;
    for (unsigned k = 1; k < thread_count_; ++k) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
    PairCounts counts;
    for (const auto& [key, sum] : sums)
      if (sum) counts.push_back({key.first, key.second, sum});
    return counts;
  }

  double unitArea() const override { return kUnit; }

 private:
  const Scene& scene_;
  const Ids& ids_;
  unsigned thread_count_;
};

}  // namespace

std::unique_ptr<Engine> makeExactEngine(const Scene& scene, const Ids& ids, unsigned thread_count) {
  return std::make_unique<ExactEngine>(scene, ids, thread_count);
}

}  // namespace viewpeel::reference
