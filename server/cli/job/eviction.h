// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <filesystem>
#include <thread>

namespace livegs {

// Exit codes of a job in addition to those of a command (cli/commands.h): a repetition may succeed, because
// the store was not reachable or the machine took the process away. EX_TEMPFAIL of sysexits.h.
inline constexpr int kRetryExit = 75;
// A command that SIGINT ended early, with its best result so far.
inline constexpr int kInterruptedExit = 128 + SIGINT;

// While it exists, SIGTERM removes the folder and ends the process at once with kRetryExit; SIGINT and
// SIGHUP do so with 128 and their number, unless the process was started with them ignored. A command that
// stores its state or its best result sets its own handlers instead. One at a time in a process, which may be
// the first of a container: such a process ignores signals without a handler.
class Eviction {
 public:
  explicit Eviction(std::filesystem::path folder);
  // Does not return after a signal: the exit code of the work, which may have missed its files, is not used.
  ~Eviction();
  // Makes SIGTERM end the process again, after a command had its own handler.
  void listen() const;
  // Whether a signal arrived: files of the folder may be missing from then on.
  bool asked() const;
  Eviction(const Eviction&) = delete;
  Eviction& operator=(const Eviction&) = delete;

 private:
  void watch() const;

  const std::filesystem::path folder_;
  std::thread watcher_;
};

}  // namespace livegs
