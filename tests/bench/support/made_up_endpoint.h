// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>

#include "core/result.h"

// A server of chat completions in a process of its own, which says after a while what the offline estimate
// said that it was told: it passes the gate at once. No model.

namespace livegs {

class MadeUpEndpoint {
 public:
  // Starts this program anew with kServe; ended with this object.
  static Result<MadeUpEndpoint> start();
  MadeUpEndpoint(MadeUpEndpoint&& other) noexcept;
  ~MadeUpEndpoint();

  const std::string& base_url() const { return base_url_; }

 private:
  MadeUpEndpoint() = default;
  pid_t process_ = -1;
  int end_of_life_ = -1;  // while it is open, the server lives
  std::string base_url_;
};

inline constexpr const char* kServe = "--serve-made-up-answers";
// What main() does then: prints its address and answers, each after `delay`, until its input ends.
int serve_made_up_answers(std::chrono::milliseconds delay);

}  // namespace livegs
