// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "session/tick/tick_result.h"

namespace livegs {

// Discards all input.
class NoInputs final : public InputSink {
 public:
  void on_input(SessionNumber, std::span<const InputSample>) override {}
  void on_session_closed(SessionNumber) override {}
};

}  // namespace livegs
