// Running is the program as a background process.
#pragma once
#include <chrono>
#include <csignal>
#include <thread>

#include "host/stopwatch.h"
#include "tests/support/program.h"

namespace viewpeel {

inline void waitFor(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

// A program that is asked to stop ends within this time, s: 2 s, and a margin for a busy machine. Under a sanitizer it
// is ten times slower.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kSoon = 60;
#else
constexpr double kSoon = 5;
#endif

class Running {
 public:
  // In: before: shell commands that run before the program; launcher: words before the program's name, as of mpirun
  Running(const std::string& arguments, const std::string& messages, const std::string& before = "",
          const std::string& launcher = "") {
    pid_ = ::fork();
    if (pid_ == 0) {
      const std::string command =
          before + "exec " + launcher + " " VIEWPEEL_PROGRAM " " + arguments + " >" + messages + " 2>&1 </dev/null";
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
  }
  ~Running() {
    if (!hasEnded()) {
      send(SIGKILL);
      wait();
    }
  }
  pid_t pid() const { return pid_; }
  void send(int signal) { ::kill(pid_, signal); }
  bool hasEnded() { return ended_ || (ended_ = ::waitpid(pid_, &status_, WNOHANG) == pid_); }
  // Returns the exit status, or minus the number of the signal that ended the program.
  int wait() {
    if (!ended_) ::waitpid(pid_, &status_, 0);
    ended_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
  }

 private:
  pid_t pid_;
  int status_ = 0;
  bool ended_ = false;
};

}  // namespace viewpeel
