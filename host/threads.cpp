#include "threads.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "control_groups.h"

namespace viewpeel {

namespace {

std::atomic<size_t> most_threads = 0;

size_t processorsAllowed() {
  static const double quota = processorQuota();
  cpu_set_t allowed;
  const int processors = ::sched_getaffinity(0, sizeof allowed, &allowed) == 0
                             ? CPU_COUNT(&allowed)
                             : static_cast<int>(std::thread::hardware_concurrency());
  return static_cast<size_t>(std::max(1.0, std::min(double(processors), std::ceil(quota))));
}

}  // namespace

size_t threadCount() {
  const size_t limit = most_threads, allowed = processorsAllowed();
  return limit ? std::min(limit, allowed) : allowed;
}

void limitThreads(size_t most) { most_threads = most; }

size_t threadsFor(size_t entries) {
  constexpr size_t kFew = 20'000;  // entries that take about 0.1 ms
  return entries < kFew ? 1 : threadCount();
}

void shareOut(size_t threads, size_t tasks, size_t chunk,
              const std::function<void(size_t thread, size_t task)>& do_task,
              const std::function<void(size_t done)>& on_done) {
  std::atomic<size_t> next = 0, done = 0;
  std::atomic<bool> stopped = false;
  std::exception_ptr failure;
  std::mutex failing;
  const auto work = [&](size_t thread) {
    try {
      for (size_t first = next.fetch_add(chunk); first < tasks && !stopped; first = next.fetch_add(chunk)) {
        const size_t end = std::min(first + chunk, tasks);
        for (size_t task = first; task < end && !stopped; ++task) do_task(thread, task);
        done += end - first;
        if (thread == 0 && on_done) on_done(done);
      }
    } catch (...) {
      const std::lock_guard lock(failing);
      if (!failure) failure = std::current_exception();
      stopped = true;
    }
  };
  {
    std::vector<std::jthread> others;
    const size_t most = std::min(threads, (tasks + chunk - 1) / chunk);
    try {
      for (size_t thread = 1; thread < most; ++thread) others.emplace_back(work, thread);
    } catch (const std::system_error&) {  // no memory is left for another thread, so that fewer threads do the work
    }
    work(0);
  }
  if (failure) std::rethrow_exception(failure);
  if (on_done) on_done(tasks);
}

}  // namespace viewpeel
