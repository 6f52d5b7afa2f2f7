// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "session/tick/tick_result.h"

namespace livegs {

// What clients may do to the course of a running scene. Any thread; no call waits for the simulation or for a
// scene that is loaded.
class RunControl {
 public:
  virtual ~RunControl() = default;
  virtual Result<RunStatus> control(const v1::ControlRunRequest& request) = 0;
  // On an object that is there.
  virtual Result<void> apply_force(const v1::Event::Force& force) = 0;
};

inline void write_run(const RunStatus& status, v1::RunState& message) {
  message.set_paused(status.paused);
  message.set_loading(status.loading);
  message.set_resets(status.resets);
  message.set_simulated_s(status.simulated_s);
  message.set_message(status.message);
}

}  // namespace livegs
