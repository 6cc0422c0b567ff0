#include "program/interrupts.h"

#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <system_error>
#include <thread>

#include <fmt/core.h>

#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

constexpr std::chrono::milliseconds kGrace(1500);  // a run ends within two seconds of a signal; the rest is for writing

std::atomic<int> received = 0, looks = 0;              // looks: number of SIGUSR1 not yet handled, 0 or 1
static_assert(std::atomic<int>::is_always_lock_free);  // a signal handler may use it
sem_t word;                                            // wakes the other thread; the signal handler posts it

struct Watch {
  std::function<int()> first_end, end;
  std::atomic<bool> has_results = false;
  std::atomic<bool> is_ending = false;  // one of the two threads is ending the program
  std::mutex at_work;                   // held by the run, except while the other thread may end it
};
Watch* watch = nullptr;  // never destroyed, for the other thread outlives main

[[noreturn]] void leave(const std::function<int()>& end) {
  int status = 1;
  try {
    status = end();
  } catch (const std::exception& error) {
    fmt::print(stderr, "viewpeel: {}\n", error.what());
  }
  std::fflush(nullptr);
  ::_exit(status);  // without waiting for the device, which may be busy for long
}

void watchForWord() {
  while (::sem_wait(&word) != 0) {
  }
  std::this_thread::sleep_for(kGrace);
  const bool has_results = watch->has_results;
  if (has_results) watch->at_work.lock();
  if (watch->is_ending.exchange(true)) {
    if (has_results) watch->at_work.unlock();
    return;
  }
  leave(has_results ? watch->end : watch->first_end);
}

}  // namespace

void holdInterrupts(std::function<int()> end) {
  watch = new Watch;
  watch->first_end = std::move(end);
  watch->at_work.lock();
  ::sem_init(&word, 0, 0);
  try {
    std::thread(watchForWord).detach();
  } catch (const std::system_error& error) {
    throw Error(ErrorCode::memory,
                fmt::format("cannot start a thread: {}; allow more memory or processes", error.code().message()));
  }
  struct sigaction hold {};
  hold.sa_handler = [](int signal) {
    received = signal;
    ::sem_post(&word);
  };
  hold.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction old {};
    ::sigaction(signal, nullptr, &old);
    if (signal != SIGHUP || old.sa_handler != SIG_IGN) ::sigaction(signal, &hold, nullptr);
  }
  struct sigaction look {};
  look.sa_handler = [](int) { looks = 1; };
  look.sa_flags = SA_RESTART;
  ::sigaction(SIGUSR1, &look, nullptr);
}

int interruption() { return received; }

const char* interruptionName() {
  const int signal = received;
  return signal == SIGINT ? "SIGINT" : signal == SIGHUP ? "SIGHUP" : "SIGTERM";
}

bool wantsResults() { return looks.exchange(0) != 0; }

void offerResults(std::function<int()> end) {
  if (!watch) return;
  watch->end = std::move(end);
  watch->has_results = true;
}

void letOthersEnd(bool begins) {
  if (!watch) return;
  if (begins) watch->at_work.unlock();
  else watch->at_work.lock();
}

void endByItself() {
  if (!watch || !watch->is_ending.exchange(true)) return;
  for (;;) ::pause();
}

}  // namespace viewpeel::program
