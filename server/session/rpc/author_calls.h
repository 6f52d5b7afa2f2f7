// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>

#include "livegs/v1/session.grpc.pb.h"
#include "session/tick/author_control.h"

namespace livegs {

// The calls of livegs.v1.LiveGs that edit a scene.
class AuthorCalls
    : public v1::LiveGs::WithCallbackMethod_EditScene<
          v1::LiveGs::WithCallbackMethod_UndoEdit<v1::LiveGs::WithCallbackMethod_CarryObject<
              v1::LiveGs::WithCallbackMethod_GetScene<v1::LiveGs::WithCallbackMethod_SaveScene<
                  v1::LiveGs::WithCallbackMethod_ListAssets<v1::LiveGs::WithCallbackMethod_UploadAsset<
                      v1::LiveGs::WithCallbackMethod_GetRoomParts<v1::LiveGs::WithCallbackMethod_TakePart<
                          v1::LiveGs::WithCallbackMethod_PutBack<v1::LiveGs::Service>>>>>>>>>> {
 public:
  grpc::ServerUnaryReactor* EditScene(grpc::CallbackServerContext* context,
                                      const v1::EditSceneRequest* request,
                                      v1::EditSceneReply* reply) override;
  grpc::ServerUnaryReactor* UndoEdit(grpc::CallbackServerContext* context, const v1::UndoEditRequest* request,
                                     v1::EditSceneReply* reply) override;
  grpc::ServerUnaryReactor* CarryObject(grpc::CallbackServerContext* context,
                                        const v1::CarryObjectRequest* request,
                                        v1::CarryObjectReply* reply) override;
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context, const v1::GetSceneRequest* request,
                                     v1::SceneDocument* reply) override;
  grpc::ServerUnaryReactor* SaveScene(grpc::CallbackServerContext* context,
                                      const v1::SaveSceneRequest* request,
                                      v1::SaveSceneReply* reply) override;
  grpc::ServerUnaryReactor* ListAssets(grpc::CallbackServerContext* context,
                                       const v1::ListAssetsRequest* request,
                                       v1::ListAssetsReply* reply) override;
  grpc::ServerReadReactor<v1::UploadAssetChunk>* UploadAsset(grpc::CallbackServerContext* context,
                                                             v1::UploadAssetReply* reply) override;

  grpc::ServerUnaryReactor* GetRoomParts(grpc::CallbackServerContext* context,
                                         const v1::GetRoomPartsRequest* request,
                                         v1::RoomParts* reply) override;
  grpc::ServerUnaryReactor* TakePart(grpc::CallbackServerContext* context, const v1::TakePartRequest* request,
                                     v1::TakePartReply* reply) override;
  grpc::ServerUnaryReactor* PutBack(grpc::CallbackServerContext* context, const v1::PutBackRequest* request,
                                    v1::EditSceneReply* reply) override;

  // Enables editing; null disables it. Must outlive the calls.
  void set_author(AuthorControl* author) { author_ = author; }

 protected:
  AuthorControl* author() const { return author_; }

 private:
  std::atomic<AuthorControl*> author_ = nullptr;
};

}  // namespace livegs
