// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/author_calls.h"

#include "session/rpc/grpc_status.h"

namespace livegs {
namespace {

grpc::Status not_open() {
  return {grpc::StatusCode::UNAVAILABLE,
          "scene: cannot be edited: it is still loading, or this server allows no edits; try again later"};
}

// Answers a call from any thread, once.
template <class Reply>
AuthorControl::Answer<Reply> answer_to(grpc::ServerUnaryReactor* reactor, Reply* reply) {
  return [reactor, reply](Result<Reply> result) {
    if (result) *reply = *std::move(result);
    reactor->Finish(result ? grpc::Status::OK : to_status(result.error()));
  };
}

class UploadCall final : public grpc::ServerReadReactor<v1::UploadAssetChunk> {
 public:
  UploadCall(grpc::CallbackServerContext* context, AuthorControl* author, v1::UploadAssetReply* reply)
      : context_(context), author_(author), reply_(reply) {
    if (author_)
      StartRead(&chunk_);
    else
      end(not_open());
  }

  void OnReadDone(bool ok) override {
    if (ended_) return;
    if (!ok && context_->IsCancelled()) return end(grpc::Status::CANCELLED);
    if (!ok) {  // the client has sent everything
      if (!upload_) return end({grpc::StatusCode::INVALID_ARGUMENT, "name: is missing; send it first"});
      auto path = upload_->finish();
      if (!path) return end(to_status(path.error()));
      reply_->set_path(*path);
      return end(grpc::Status::OK);
    }
    if (!upload_) {
      auto begun = author_->upload(chunk_.name());
      if (!begun) return end(to_status(begun.error()));
      upload_ = *std::move(begun);
    }
    const auto added = upload_->add(std::as_bytes(std::span(chunk_.data().data(), chunk_.data().size())));
    if (!added) return end(to_status(added.error()));
    StartRead(&chunk_);
  }
  void OnCancel() override {}
  void OnDone() override { delete this; }

 private:
  void end(const grpc::Status& status) {
    ended_ = true;
    Finish(status);
  }

  grpc::CallbackServerContext* context_;
  AuthorControl* author_;
  v1::UploadAssetReply* reply_;
  v1::UploadAssetChunk chunk_;
  std::unique_ptr<AuthorControl::Upload> upload_;
  bool ended_ = false;
};

}  // namespace

grpc::ServerUnaryReactor* AuthorCalls::EditScene(grpc::CallbackServerContext* context,
                                                 const v1::EditSceneRequest* request,
                                                 v1::EditSceneReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  if (AuthorControl* author = author_)
    author->edit(*request, answer_to(reactor, reply));
  else
    reactor->Finish(not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::UndoEdit(grpc::CallbackServerContext* context,
                                                const v1::UndoEditRequest* request,
                                                v1::EditSceneReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  if (AuthorControl* author = author_)
    author->undo(request->redo(), answer_to(reactor, reply));
  else
    reactor->Finish(not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::CarryObject(grpc::CallbackServerContext* context,
                                                   const v1::CarryObjectRequest* request,
                                                   v1::CarryObjectReply*) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AuthorControl* author = author_;
  const Result<void> carried = author ? author->carry(*request) : Result<void>();
  reactor->Finish(!author ? not_open() : carried ? grpc::Status::OK : to_status(carried.error()));
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::GetScene(grpc::CallbackServerContext* context,
                                                const v1::GetSceneRequest*, v1::SceneDocument* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AuthorControl* author = author_;
  if (author) *reply = author->document();
  reactor->Finish(author ? grpc::Status::OK : not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::SaveScene(grpc::CallbackServerContext* context,
                                                 const v1::SaveSceneRequest* request,
                                                 v1::SaveSceneReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  if (AuthorControl* author = author_)
    author->save(*request, answer_to(reactor, reply));
  else
    reactor->Finish(not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::ListAssets(grpc::CallbackServerContext* context,
                                                  const v1::ListAssetsRequest*, v1::ListAssetsReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AuthorControl* author = author_;
  if (author) *reply = author->assets();
  reactor->Finish(author ? grpc::Status::OK : not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::GetRoomParts(grpc::CallbackServerContext* context,
                                                    const v1::GetRoomPartsRequest*, v1::RoomParts* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AuthorControl* author = author_;
  if (author) *reply = author->room_parts();
  reactor->Finish(author ? grpc::Status::OK : not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::TakePart(grpc::CallbackServerContext* context,
                                                const v1::TakePartRequest* request,
                                                v1::TakePartReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  if (AuthorControl* author = author_)
    author->take_part(*request, answer_to(reactor, reply));
  else
    reactor->Finish(not_open());
  return reactor;
}

grpc::ServerUnaryReactor* AuthorCalls::PutBack(grpc::CallbackServerContext* context,
                                               const v1::PutBackRequest* request, v1::EditSceneReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  if (AuthorControl* author = author_)
    author->put_back(request->object(), answer_to(reactor, reply));
  else
    reactor->Finish(not_open());
  return reactor;
}

grpc::ServerReadReactor<v1::UploadAssetChunk>* AuthorCalls::UploadAsset(grpc::CallbackServerContext* context,
                                                                        v1::UploadAssetReply* reply) {
  return new UploadCall(context, author_, reply);
}

}  // namespace livegs
