// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/spectator_service.h"

#include "session/rpc/grpc_status.h"
#include "session/support/version.h"
#include "wire/frame_codec.h"

namespace livegs {

grpc::ServerUnaryReactor* SpectatorService::DescribeScene(grpc::CallbackServerContext* context,
                                                          const v1::DescribeSceneRequest* request,
                                                          v1::SceneDescription* reply) {
  const auto finish = [&](const grpc::Status& status) {
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    reactor->Finish(status);
    return reactor;
  };
  if (request->protocol_version() != kProtocolVersion) {
    return finish({grpc::StatusCode::FAILED_PRECONDITION,
                   "protocol: the client has version " + std::to_string(request->protocol_version()) +
                       " and the server (livegs " + kVersion + ") version " +
                       std::to_string(kProtocolVersion) + "; update the older one"});
  }
  const auto scene = table_.described();
  if (!scene) return finish(to_status(scene.error()));
  reply->set_scene(scene->scene);
  reply->set_rate_hz(scene->rate_hz);
  reply->set_server_instance(table_.instance());
  reply->set_event_number(scene->event_number);
  for (const SessionTable::Object& object : scene->objects) *reply->add_objects() = *object;
  return finish(grpc::Status::OK);
}

}  // namespace livegs
