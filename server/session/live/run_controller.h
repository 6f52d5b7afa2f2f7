// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <mutex>
#include <thread>

#include "session/simulation/simulation_loop.h"
#include "session/tick/run_control.h"

namespace livegs {

// Halts, steps and resets a running scene for its clients. A reset loads the scene on a thread of its own
// while the old one goes on, and puts it in its place at a tick boundary.
class RunController final : public RunControl {
 public:
  // Loads the very scene that runs, its first object with this id.
  using Load = std::function<Result<Scene>(uint32_t first_object_id)>;
  // Takes a loaded scene, on the loading thread, and gives it to the loop; left out: the loop has it at once.
  using Loaded = std::function<void(Scene)>;
  // `loop` outlives this.
  RunController(SimulationLoop& loop, Load load, Loaded loaded = {});
  ~RunController() override;  // waits for a scene that is being loaded

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
