// SPDX-License-Identifier: Apache-2.0
#include "stream/session/scene_control.h"

#include <chrono>
#include <mutex>
#include <set>

#include "livegs/v1/session.grpc.pb.h"
#include "stream/channel/rpc_channel.h"

namespace livegs {
namespace {

constexpr std::chrono::seconds kControlDeadline{10};

}  // namespace

struct SceneControl::Connection {
  std::string address;
  std::unique_ptr<v1::LiveGs::Stub> stub;
  std::mutex mutex;  // guards the two members below
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

  template <class Reply, class Request>
  Result<Reply> ask(grpc::Status (v1::LiveGs::Stub::*method)(grpc::ClientContext*, const Request&, Reply*),
                    const Request& request) {
    Call call(*this);
    call.context.set_deadline(std::chrono::system_clock::now() + kControlDeadline);
    Reply reply;
    const grpc::Status status = (stub.get()->*method)(&call.context, request, &reply);
    if (!status.ok()) return error_from(status, address);
    return reply;
  }
};

SceneControl::SceneControl(const std::string& address, std::shared_ptr<const ServerAccess> access)
    : connection_(std::make_unique<Connection>()) {
  connection_->address = address;
  connection_->stub = v1::LiveGs::NewStub(make_channel(address, access.get()));
}

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

Result<void> SceneControl::analyze(const std::vector<std::string>& objects, const Progress& progress) {
  v1::AnalyzeSceneRequest request;
  for (const std::string& object : objects) request.add_objects(object);
  Connection::Call call(*connection_);
  const auto reader = connection_->stub->AnalyzeScene(&call.context, request);
  v1::AnalysisProgress reported;
  while (reader->Read(&reported)) progress(reported);
  const grpc::Status status = reader->Finish();
  if (!status.ok()) return error_from(status, connection_->address);
  return {};
}

void SceneControl::cancel() {
  std::lock_guard lock(connection_->mutex);
  connection_->cancelled = true;
  for (grpc::ClientContext* context : connection_->under_way) context->TryCancel();
}

}  // namespace livegs
