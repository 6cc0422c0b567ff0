#include "cli/interrupts.h"

#include <atomic>
#include <csignal>

#include "estimator/estimate.h"

namespace viewpeel::cli {
namespace {

std::atomic<int> received = 0;
static_assert(std::atomic<int>::is_always_lock_free);  // what a signal handler may touch

}  // namespace

void holdInterrupts() {
  struct sigaction hold {};
  hold.sa_handler = [](int signal) { received = signal; };
  hold.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &hold, nullptr);
  ::sigaction(SIGTERM, &hold, nullptr);
}

void stopIfInterrupted() {
  if (received) throw Interrupted{};
}

int interruption() { return received; }

}  // namespace viewpeel::cli
