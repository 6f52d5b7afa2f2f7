// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/support/server_callback.h>

#include <memory>

#include "livegs/v1/session.pb.h"
#include "session/assets/asset_store.h"

namespace livegs {

// Bytes of a chunk. A broken connection loses at most one chunk, which is fetched again.
inline constexpr size_t kAssetChunkBytes = 64u << 10;

// One FetchAsset rpc: sends chunks in order from an offset, paced by gRPC's flow control. Deletes itself.
class AssetCall final : public grpc::ServerWriteReactor<v1::AssetChunk> {
 public:
  // `asset` may be null: NOT_FOUND. An offset past the end gives OUT_OF_RANGE, an offset at the end an empty
  // stream.
  AssetCall(std::shared_ptr<const AssetBytes> asset, uint64_t offset);

 private:
  void write_next();
  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

  std::shared_ptr<const AssetBytes> asset_;
  uint64_t offset_;
  v1::AssetChunk chunk_;
};

}  // namespace livegs
