// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "stream/channel/server_place.h"
#include "trust/server_access.h"

namespace livegs {

// Control of a running scene (parameters, analysis, run state) over its own connection, so that calls do not
// delay frames. Calls block for up to ten seconds; any thread. Errors are the server's one-line message,
// which names the field.
class SceneControl {
 public:
  // `access`: null for a connection without TLS.
  explicit SceneControl(const std::string& address, std::shared_ptr<const ServerAccess> access = nullptr);
  // Follows a session to its next server.
  explicit SceneControl(std::shared_ptr<const ServerPlace> place);
  ~SceneControl();

  Result<v1::PhysicsReply> set_physics(const std::string& object, const v1::Physics& physics);
  Result<v1::PhysicsReply> accept_proposal(const std::string& object, bool decline = false);
  Result<v1::PhysicsReply> undo_physics(const std::string& object, bool redo);
  Result<v1::RunState> control_run(const v1::ControlRunRequest& request);
  // `force`: the point in rest coordinates of the object, the direction in world coordinates.
  // Returns the newest tick at acceptance; the force acts from the next tick on.
  Result<uint64_t> apply_force(const v1::Event::Force& force);

  // Editing (author.proto).
  Result<v1::EditSceneReply> edit_scene(const v1::EditSceneRequest& request);
  Result<v1::EditSceneReply> undo_edit(bool redo);
  Result<void> carry_object(const v1::CarryObjectRequest& request);
  Result<v1::SceneDocument> scene();
  Result<v1::SaveSceneReply> save_scene(const v1::SaveSceneRequest& request);
  Result<v1::ListAssetsReply> assets();
  Result<v1::RoomParts> room_parts();
  Result<v1::TakePartReply> take_part(const v1::TakePartRequest& request);
  Result<v1::EditSceneReply> put_back(const std::string& object);
  // Sends a file; blocks until the server has it, without a time limit. Returns its path as Object.asset.
  Result<std::string> upload_asset(const std::filesystem::path& file);

  // Blocks until all objects are analysed, without a time limit. No names: every object marked for analysis.
  // `progress` is called on this thread.
  using Progress = std::function<void(const v1::AnalysisProgress&)>;
  Result<void> analyze(const std::vector<std::string>& objects, const Progress& progress);

  // Ends running calls on any thread; later calls fail at once.
  void cancel();

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
