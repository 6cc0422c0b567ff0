// Ctrl-C and kill during a computation whose outcome is to be kept.
#pragma once
#include <functional>

namespace viewpeel::program {

// From here on SIGINT and SIGTERM leave word for interruption(). A run that has not come to an end 1.5 s later - a long
// batch on the device, a large scene to read - is ended from another thread: that calls `end`, or what offerResults was
// given since, and leaves the program with what it returns. A second signal ends the program at once, as ever.
void holdInterrupts(std::function<int()> end);

// The signal that came; 0 where none did. To be asked often; from any thread.
int interruption();

// There are results: between letOthersEnd(true) and letOthersEnd(false) alone the other thread may call `end`, in place
// of what was set before. What `end` reads stays as it is meanwhile.
void offerResults(std::function<int()> end);

// An engine begins to count, which need not be waited for, or has done so.
void letOthersEnd(bool begins);

// The caller's run comes to its end by itself from here on. Does not return where the other thread has begun to end it.
void endByItself();

}  // namespace viewpeel::program
