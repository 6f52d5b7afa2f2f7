// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "scratch_folder.h"

namespace livegs {

// Runs a program of this project. Its standard output and error are each kept in a file.
class Program {
 public:
  explicit Program(std::vector<std::string> words);
  ~Program();  // kills the program if it still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Waits for the exit code, or 128 + signal. Returns -1 if the program still runs after 90 s.
  int wait();
  void send(int signal_number);
  pid_t process() const { return process_; }
  std::string out() const;
  std::string err() const;
  // Waits for the first complete line of standard output. Empty if the program ends without one.
  std::string first_line();
  // Waits until standard error contains the text the given number of times. Returns false if the program ends
  // before.
  bool says(const std::string& text) { return says_often(text, 1); }
  bool says_often(const std::string& text, size_t times);

 private:
  bool wait_for(const std::string& name, const std::function<bool(const std::string&)>& enough);

  ScratchFolder folder_;
  pid_t process_ = -1;
  int exit_code_ = -1;
};

}  // namespace livegs
