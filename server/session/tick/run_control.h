// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "session/tick/tick_result.h"

namespace livegs {

// Run operations of clients on a running scene. Any thread; no call blocks on the simulation or on loading.
class RunControl {
 public:
  virtual ~RunControl() = default;
  virtual Result<RunStatus> control(const v1::ControlRunRequest& request) = 0;
  // The object must exist.
  virtual Result<void> apply_force(const v1::Event::Force& force) = 0;
};

inline void write_run(const RunStatus& status, v1::RunState& message) {
  message.set_paused(status.paused);
  message.set_loading(status.loading);
  message.set_resets(status.resets);
  message.set_simulated_s(status.simulated_s);
  message.set_message(status.message);
  message.set_edit_revision(status.edit_revision);
  message.set_waiting(status.waiting);
}

}  // namespace livegs
