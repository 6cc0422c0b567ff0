// A computation whose outcome is kept handles Ctrl-C, kill and a lost terminal by these functions.
#pragma once
#include <functional>

namespace viewpeel::program {

// From here on SIGINT, SIGTERM and SIGHUP (a terminal that is gone) only set interruption(). Another thread ends a run
// that does not end within 1.5 s, as in a long batch on the device or while a large scene is read. It calls `end`, or
// the latest function from offerResults, and leaves the program with the status that this returns. A second signal ends
// the program at once, as ever. SIGHUP stays ignored where it was, as under nohup. SIGUSR1 only sets wantsResults().
void holdInterrupts(std::function<int()> end);

// Returns the signal that came; 0 where none did. Any thread may call it, often.
int interruption();
// Returns its name: "SIGINT".
const char* interruptionName();

// Returns true once after each SIGUSR1: the results so far are to be written, and the run goes on.
bool wantsResults();

// There are results now: between letOthersEnd(true) and letOthersEnd(false) alone the other thread may call `end`, in
// place of the earlier function. Data that `end` reads stays as it is in between.
void offerResults(std::function<int()> end);

// An engine begins to count, and another thread need not wait for it; or it has done so.
void letOthersEnd(bool begins);

// The caller's run comes to its end by itself from here on. Does not return where the other thread has begun to end it.
void endByItself();

}  // namespace viewpeel::program
