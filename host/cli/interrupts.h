// Ctrl-C and kill during a computation whose outcome is to be kept.
#pragma once

namespace viewpeel::cli {

// From here on SIGINT and SIGTERM only leave word for stopIfInterrupted. A second one ends the program at once, as ever.
void holdInterrupts();

// To be called often; from any thread.    Throws: Interrupted once there is word.
void stopIfInterrupted();

// The signal that came; 0 where none did.
int interruption();

}  // namespace viewpeel::cli
