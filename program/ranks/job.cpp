#include "program/ranks/job.h"

#include <csignal>

namespace viewpeel::program {

void leaveSignalsToRank0() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) std::signal(signal, SIG_IGN);
}

}  // namespace viewpeel::program
