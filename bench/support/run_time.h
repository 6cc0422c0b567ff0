// timeOf() measures the elapsed time and the CPU time of a run.
#pragma once
#include <sys/resource.h>

#include "stopwatch.h"

namespace viewpeel::bench {

// RunTime covers a method until it has its result, without the conversion to a matrix for comparison. All times are in
// seconds.
struct RunTime {
  double seconds = 0;
  double cpu_seconds = 0;   // of all threads, and of child processes
  double host_seconds = 0;  // CPU time of the calling thread
};

inline double cpuSecondsOf(int who) {
  rusage usage;
  ::getrusage(who, &usage);
  return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

template <class Run>
RunTime timeOf(Run run) {
  const auto all = [] { return cpuSecondsOf(RUSAGE_SELF) + cpuSecondsOf(RUSAGE_CHILDREN); };
  const double cpu_s = all(), host_s = cpuSecondsOf(RUSAGE_THREAD);
  const Clock::time_point start = Clock::now();
  run();
  const double seconds = secondsSince(start);
  return {seconds, all() - cpu_s, cpuSecondsOf(RUSAGE_THREAD) - host_s};
}

}  // namespace viewpeel::bench
