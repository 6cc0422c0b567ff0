// Threads share out work in these functions.
#pragma once
#include <cstddef>
#include <functional>

namespace viewpeel {

// Returns the number of threads for work of any size: as many as the processors that the process may run on (taskset).
// Neither its control group's quota of time nor the last limitThreads() is exceeded.
size_t threadCount();

// Limits threadCount() from here on.    In: 0: no limit
void limitThreads(size_t most);

// Returns the number of threads for lists of this many entries, one where a second would take longer to start.
size_t threadsFor(size_t entries);

// Does tasks 0..tasks-1, `chunk` at a time by whichever thread is free; the calling thread is thread 0. Where one
// throws, no further task begins, and the first exception is thrown on.
//   In: threads > 0; do_task(thread, task): of different threads at once; on_done(tasks done): called by the calling
//   thread after its chunks and at the end; may throw, may be empty
void shareOut(size_t threads, size_t tasks, size_t chunk,
              const std::function<void(size_t thread, size_t task)>& do_task,
              const std::function<void(size_t done)>& on_done = {});

}  // namespace viewpeel
