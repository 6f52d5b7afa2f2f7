// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <mutex>
#include <thread>

#include "session/simulation/simulation_loop.h"
#include "session/tick/run_control.h"

namespace livegs {

// Pauses, steps and resets a running scene for clients. A reset loads the scene on its own thread while the
// old one continues, and replaces it at a tick boundary.
class RunController final : public RunControl {
 public:
  // Loads the scene again, with this id for its first object.
  using Load = std::function<Result<Scene>(uint32_t first_object_id)>;
  // Passes a loaded scene to the loop; called on the loading thread. Default: directly.
  using Loaded = std::function<void(Scene)>;
  // `loop` must outlive this.
  RunController(SimulationLoop& loop, Load load, Loaded loaded = {});
  ~RunController() override;  // waits until loading has finished

  Result<RunStatus> control(const v1::ControlRunRequest& request) override;
  Result<void> apply_force(const v1::Event::Force& force) override;

 private:
  Result<void> reset();

  SimulationLoop& loop_;
  Load load_;
  Loaded loaded_;
  std::mutex mutex_;  // guards loading_
  std::jthread loading_;
};

}  // namespace livegs
