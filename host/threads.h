// These functions choose the number of threads and share out tasks among them.
#pragma once
#include <cstddef>
#include <functional>

namespace viewpeel {

// Returns the number of threads for work of any size: the number of processors that the process may run on (taskset).
// The quota of its control group, rounded up, and the last limitThreads() may lower it.
size_t threadCount();

// Limits threadCount() from now on.    In: most: 0 for no limit
void limitThreads(size_t most);

// Returns the number of threads for lists of this many entries. It is 1 if a second thread would take longer to start
// than the work takes.
size_t threadsFor(size_t entries);

// Runs tasks 0..tasks-1 in chunks of `chunk` on whichever thread is free; the calling thread is thread 0. If a task
// throws, no further task begins, and the first exception is rethrown. Threads that cannot be started are done without.
//   In: threads > 0; do_task(thread, task): threads call it concurrently; on_done(tasks done): the calling thread calls
//   it after each of its chunks and at the end; it may throw, and may be empty
void shareOut(size_t threads, size_t tasks, size_t chunk,
              const std::function<void(size_t thread, size_t task)>& do_task,
              const std::function<void(size_t done)>& on_done = {});

}  // namespace viewpeel
