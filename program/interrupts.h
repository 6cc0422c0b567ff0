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
// Returns that signal's name: "SIGINT".
const char* interruptionName();

// Returns true once after each SIGUSR1, which asks for the results so far without an end of the run.
bool wantsResults();

// Replaces the function that the other thread calls: results exist now. It is called only between letOthersEnd(true)
// and letOthersEnd(false). The caller must not change the data that `end` reads in between.
void offerResults(std::function<int()> end);

// Tells the other thread that an engine begins to count, so that it need not wait for the run; or that it has ended.
void letOthersEnd(bool begins);

// The caller ends the run itself after this call. It does not return where the other thread has begun to end it.
void endByItself();

}  // namespace viewpeel::program
