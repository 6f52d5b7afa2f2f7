// SPDX-License-Identifier: Apache-2.0
#include "stream/session/scene_control.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <set>

#include "core/file.h"
#include "livegs/v1/session.grpc.pb.h"
#include "stream/channel/rpc_channel.h"

namespace livegs {
namespace {

constexpr std::chrono::seconds kControlDeadline{10};
constexpr std::chrono::seconds kBuildDeadline{120};  // of calls that may build several large objects
constexpr size_t kUploadChunkBytes = 48 << 10;       // a server takes messages of 64 kB

}  // namespace

struct SceneControl::Connection {
  explicit Connection(std::shared_ptr<const ServerPlace> given) : place(std::move(given)) {}
  const std::shared_ptr<const ServerPlace> place;
  std::mutex mutex;  // guards everything below
  std::shared_ptr<v1::LiveGs::Stub> stub;
  uint64_t stub_moves = 0;  // of the place for which the stub was made
  std::set<grpc::ClientContext*> under_way;
  bool cancelled = false;

  // Registers the context of a call with cancel() while the call runs.
  class Call {
   public:
    explicit Call(Connection& connection) : connection_(connection) {
      std::lock_guard lock(connection_.mutex);
      connection_.under_way.insert(&context);
      if (connection_.cancelled) context.TryCancel();
    }
    ~Call() {
      std::lock_guard lock(connection_.mutex);
      connection_.under_way.erase(&context);
    }
    grpc::ClientContext context;

   private:
    Connection& connection_;
  };

  std::string address() const { return place->now().address; }
  std::shared_ptr<v1::LiveGs::Stub> stub_now() {
    const ServerPlace::Place at = place->now();
    std::lock_guard lock(mutex);
    if (!stub || stub_moves != at.moves) {
      stub = v1::LiveGs::NewStub(make_channel(at.address, at.access.get()));
      stub_moves = at.moves;
    }
    return stub;
  }

  template <class Reply, class Request>
  Result<Reply> ask(grpc::Status (v1::LiveGs::Stub::*method)(grpc::ClientContext*, const Request&, Reply*),
                    const Request& request, std::chrono::seconds deadline = kControlDeadline) {
    Call call(*this);
    call.context.set_deadline(std::chrono::system_clock::now() + deadline);
    Reply reply;
    const grpc::Status status = (stub_now().get()->*method)(&call.context, request, &reply);
    if (!status.ok()) return error_from(status, address());
    return reply;
  }
};

SceneControl::SceneControl(const std::string& address, std::shared_ptr<const ServerAccess> access)
    : SceneControl(std::make_shared<const ServerPlace>(address, std::move(access))) {}

SceneControl::SceneControl(std::shared_ptr<const ServerPlace> place)
    : connection_(std::make_unique<Connection>(std::move(place))) {}

SceneControl::~SceneControl() = default;

Result<v1::PhysicsReply> SceneControl::set_physics(const std::string& object, const v1::Physics& physics) {
  v1::SetPhysicsRequest request;
  request.set_object(object);
  *request.mutable_physics() = physics;
  return connection_->ask(&v1::LiveGs::Stub::SetPhysics, request);
}

Result<v1::PhysicsReply> SceneControl::accept_proposal(const std::string& object, bool decline) {
  v1::AcceptProposalRequest request;
  request.set_object(object);
  request.set_decline(decline);
  return connection_->ask(&v1::LiveGs::Stub::AcceptProposal, request);
}

Result<v1::PhysicsReply> SceneControl::undo_physics(const std::string& object, bool redo) {
  v1::UndoPhysicsRequest request;
  request.set_object(object);
  request.set_redo(redo);
  return connection_->ask(&v1::LiveGs::Stub::UndoPhysics, request);
}

Result<v1::RunState> SceneControl::control_run(const v1::ControlRunRequest& request) {
  return connection_->ask(&v1::LiveGs::Stub::ControlRun, request);
}

Result<uint64_t> SceneControl::apply_force(const v1::Event::Force& force) {
  v1::ApplyForceRequest request;
  *request.mutable_force() = force;
  const auto reply = connection_->ask(&v1::LiveGs::Stub::ApplyForce, request);
  if (!reply) return reply.error();
  return reply->tick();
}

Result<v1::EditSceneReply> SceneControl::edit_scene(const v1::EditSceneRequest& request) {
  return connection_->ask(&v1::LiveGs::Stub::EditScene, request, kBuildDeadline);
}

Result<v1::EditSceneReply> SceneControl::undo_edit(bool redo) {
  v1::UndoEditRequest request;
  request.set_redo(redo);
  return connection_->ask(&v1::LiveGs::Stub::UndoEdit, request, kBuildDeadline);
}

Result<void> SceneControl::carry_object(const v1::CarryObjectRequest& request) {
  const auto reply = connection_->ask(&v1::LiveGs::Stub::CarryObject, request);
  return reply ? Result<void>() : reply.error();
}

Result<v1::SceneDocument> SceneControl::scene() {
  return connection_->ask(&v1::LiveGs::Stub::GetScene, v1::GetSceneRequest());
}

Result<v1::SaveSceneReply> SceneControl::save_scene(const v1::SaveSceneRequest& request) {
  return connection_->ask(&v1::LiveGs::Stub::SaveScene, request, kBuildDeadline);
}

Result<v1::ListAssetsReply> SceneControl::assets() {
  return connection_->ask(&v1::LiveGs::Stub::ListAssets, v1::ListAssetsRequest());
}

Result<v1::RoomParts> SceneControl::room_parts() {
  return connection_->ask(&v1::LiveGs::Stub::GetRoomParts, v1::GetRoomPartsRequest());
}

Result<v1::TakePartReply> SceneControl::take_part(const v1::TakePartRequest& request) {
  return connection_->ask(&v1::LiveGs::Stub::TakePart, request, kBuildDeadline);
}

Result<v1::EditSceneReply> SceneControl::put_back(const std::string& object) {
  v1::PutBackRequest request;
  request.set_object(object);
  return connection_->ask(&v1::LiveGs::Stub::PutBack, request, kBuildDeadline);
}

Result<std::string> SceneControl::upload_asset(const std::filesystem::path& file) {
  auto bytes = read_file(file);
  if (!bytes) return bytes.error();
  Connection::Call call(*connection_);
  v1::UploadAssetReply reply;
  const auto stub = connection_->stub_now();
  const auto writer = stub->UploadAsset(&call.context, &reply);
  v1::UploadAssetChunk chunk;
  chunk.set_name(file.filename().string());
  bool open = writer->Write(chunk);
  chunk.clear_name();
  for (size_t sent = 0; open && sent < bytes->size(); sent += chunk.data().size()) {
    chunk.set_data(bytes->data() + sent, std::min(kUploadChunkBytes, bytes->size() - sent));
    open = writer->Write(chunk);
  }
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  if (!status.ok()) return error_from(status, connection_->address());
  return reply.path();
}

Result<void> SceneControl::analyze(const std::vector<std::string>& objects, const Progress& progress) {
  v1::AnalyzeSceneRequest request;
  for (const std::string& object : objects) request.add_objects(object);
  Connection::Call call(*connection_);
  const auto stub = connection_->stub_now();
  const auto reader = stub->AnalyzeScene(&call.context, request);
  v1::AnalysisProgress reported;
  while (reader->Read(&reported)) progress(reported);
  const grpc::Status status = reader->Finish();
  if (!status.ok()) return error_from(status, connection_->address());
  return {};
}

void SceneControl::cancel() {
  std::lock_guard lock(connection_->mutex);
  connection_->cancelled = true;
  for (grpc::ClientContext* context : connection_->under_way) context->TryCancel();
}

}  // namespace livegs
