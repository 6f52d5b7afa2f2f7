// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>

#include "core/result.h"

// A chat-completions server in another process, without a model. After a delay, it repeats the offline
// estimate of the request, which the gate accepts at once.

namespace livegs {

class MadeUpEndpoint {
 public:
  // Starts this program with kServe. The process ends with this object.
  static Result<MadeUpEndpoint> start();
  MadeUpEndpoint(MadeUpEndpoint&& other) noexcept;
  ~MadeUpEndpoint();

  const std::string& base_url() const { return base_url_; }

 private:
  MadeUpEndpoint() = default;
  pid_t process_ = -1;
  int end_of_life_ = -1;  // the server runs while this is open
  std::string base_url_;
};

inline constexpr const char* kServe = "--serve-made-up-answers";
// The main function of that process: prints its address and answers requests after `delay`, until its input
// ends.
int serve_made_up_answers(std::chrono::milliseconds delay);

}  // namespace livegs
