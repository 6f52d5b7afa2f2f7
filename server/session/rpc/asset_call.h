// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/alarm.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <mutex>

#include "livegs/v1/session.pb.h"
#include "session/assets/asset_store.h"
#include "session/sessions/client_session.h"

namespace livegs {

// Upper bound of the bytes of a chunk. A broken connection loses at most one chunk, which is fetched again.
inline constexpr size_t kAssetChunkBytes = 64u << 10;

// One FetchAsset rpc: sends chunks in order from an offset, paced by the budget of the client and by gRPC's
// flow control. gRPC and the timer call it on their own threads. Lives until OnDone.
class AssetCall final : public grpc::ServerWriteReactor<v1::AssetChunk>,
                        public std::enable_shared_from_this<AssetCall> {
 public:
  // An unknown hash or edit gives NOT_FOUND, an offset past the end OUT_OF_RANGE, an offset at the end an
  // empty stream. `session`: the session that fetches, which is kept from timing out; null without one.
  // `assets` outlives the call.
  static AssetCall* start(const AssetStore& assets, const v1::FetchAssetRequest& request,
                          std::shared_ptr<SendBudget> budget, std::shared_ptr<ClientSession> session);
  ~AssetCall() override { budget_->leave(this); }

 private:
  AssetCall(const AssetStore& assets, AssetStore::Bytes bytes, uint64_t offset,
            std::shared_ptr<SendBudget> budget, std::shared_ptr<ClientSession> session)
      : assets_(assets),
        bytes_(std::move(bytes)),
        budget_(std::move(budget)),
        session_(std::move(session)),
        offset_(offset) {}

  void write_next();
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  const AssetStore& assets_;
  const AssetStore::Bytes bytes_;  // null: not found
  const std::shared_ptr<SendBudget> budget_;
  const std::shared_ptr<ClientSession> session_;
  uint64_t offset_;  // at most one write or wait is in progress, which owns this and the chunk
  v1::AssetChunk chunk_;
  std::shared_ptr<AssetCall> self_;  // gRPC's reference, released in OnDone

  std::mutex mutex_;  // guards everything below
  bool cancelled_ = false;
  grpc::Alarm turn_;
};

}  // namespace livegs
