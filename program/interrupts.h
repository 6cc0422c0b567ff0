// A command that keeps its result handles Ctrl-C, kill and a closed terminal by these functions.
#pragma once
#include <functional>

namespace viewpeel::program {

// After this call SIGINT, SIGTERM and SIGHUP (a closed terminal) only set interruption(), and the run ends itself.
// Another thread waits 1.5 s, for the run may be within a long batch on the device or reading a large scene. It then
// calls `end`, or the latest function from offerResults, and exits with the returned status. A second signal ends the
// program at once. An ignored SIGHUP, as under nohup, stays ignored. SIGUSR1 only sets wantsResults().
void holdInterrupts(std::function<int()> end);

// Returns the signal that was received; 0 where none was. Any thread may call it, often.
int interruption();
// Returns the name of the received signal, such as "SIGINT".
const char* interruptionName();

// Returns true once after each SIGUSR1, which asks for the results so far without an end of the run.
bool wantsResults();

// Replaces the function that the other thread calls after a signal, for from now on there are results to write. The
// other thread calls `end` only between letOthersEnd(true) and letOthersEnd(false). Between these two calls the caller
// must not change what `end` reads.
void offerResults(std::function<int()> end);

// Says that an engine begins to count, so that the other thread may end the program meanwhile; with false, that the
// engine has stopped and the program must not be ended until the next call.
void letOthersEnd(bool begins);

// Announces that the caller is about to end the program itself, so that the other thread does not. This function does
// not return where the other thread has already begun to end the program.
void endByItself();

}  // namespace viewpeel::program
