// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "livegs/v1/spectate.grpc.pb.h"
#include "session/sessions/session_table.h"

namespace livegs {

// livegs.v1.Spectators: the scene data that published frames do not contain. CallAuthoriser checks the
// caller. Does not block.
class SpectatorService final : public v1::Spectators::CallbackService {
 public:
  explicit SpectatorService(const SessionTable& table) : table_(table) {}
  grpc::ServerUnaryReactor* DescribeScene(grpc::CallbackServerContext* context,
                                          const v1::DescribeSceneRequest* request,
                                          v1::SceneDescription* reply) override;

 private:
  const SessionTable& table_;
};

}  // namespace livegs
