// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "trust/server_access.h"

namespace livegs {

// What a person may do to a running scene besides touching it, over a connection of its own, so that no frame
// waits behind it. Calls block, ten seconds at most; any thread. Errors are the server's one line, which
// names the field.
class SceneControl {
 public:
  // `access`: null in the clear.
  explicit SceneControl(const std::string& address, std::shared_ptr<const ServerAccess> access = nullptr);
  ~SceneControl();

  Result<v1::PhysicsReply> set_physics(const std::string& object, const v1::Physics& physics);
  Result<v1::PhysicsReply> accept_proposal(const std::string& object, bool decline = false);
  Result<v1::PhysicsReply> undo_physics(const std::string& object, bool redo);
  Result<v1::RunState> control_run(const v1::ControlRunRequest& request);
  // `force` in the object's rest coordinates, the direction in the world's.
  // Gives the newest tick when it was taken; it acts from the next on.
  Result<uint64_t> apply_force(const v1::Event::Force& force);

  // Until all are finished, however long that takes; no names: every object that is left to the analysis.
  // `progress` is called on this thread.
  using Progress = std::function<void(const v1::AnalysisProgress&)>;
  Result<void> analyze(const std::vector<std::string>& objects, const Progress& progress);

  // Ends calls that are under way, on whatever thread; those to come fail at once.
  void cancel();

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
