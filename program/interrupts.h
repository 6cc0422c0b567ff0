// Ctrl-C and kill during a computation whose outcome is to be kept.
#pragma once
#include <functional>
#include <memory>

#include "engines/engine.h"

namespace viewpeel::program {

// From here on SIGINT and SIGTERM leave word for stopIfInterrupted. A run that has not come to an end 1.5 s later - a long batch on the device, a large
// scene to read - is ended from another thread: that calls `end`, or what offerResults was given since, and leaves the program with what it returns.
// A second signal ends the program at once, as ever.
void holdInterrupts(std::function<int()> end);

// To be called often; from any thread.    Throws: Interrupted once there is word.
void stopIfInterrupted();

// The signal that came; 0 where none did.
int interruption();

// There are results: only while an engine of `interruptible` counts may the other thread now call `end`, in place of what was set before. What `end` reads
// stays as it is meanwhile.
void offerResults(std::function<int()> end);

// The engine, with its calls to count marked as what need not be waited for.
std::unique_ptr<Engine> interruptible(Engine& engine);

// The caller's run comes to its end by itself from here on. Does not return where the other thread has begun to end it.
void endByItself();

}  // namespace viewpeel::program
