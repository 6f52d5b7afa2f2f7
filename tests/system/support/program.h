// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "scratch_folder.h"

namespace livegs {

// A program of ours, run as a person would, its output kept in a file each.
class Program {
 public:
  explicit Program(std::vector<std::string> words);
  ~Program();  // killed if it is still there
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // The exit code, or 128 + the signal that ended it; -1 when it is still running after a minute and a half.
  int wait();
  void send(int signal_number);
  pid_t process() const { return process_; }
  std::string out() const;
  std::string err() const;
  // Waits for the first whole line on its standard output; empty when it ends without one.
  std::string first_line();
  // Waits until this stands in its standard error, so often; false when it ends without it.
  bool says(const std::string& text) { return says_often(text, 1); }
  bool says_often(const std::string& text, size_t times);

 private:
  bool wait_for(const std::string& name, const std::function<bool(const std::string&)>& enough);

  ScratchFolder folder_;
  pid_t process_ = -1;
  int exit_code_ = -1;
};

}  // namespace livegs
