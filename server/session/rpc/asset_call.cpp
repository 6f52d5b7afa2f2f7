// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/asset_call.h"

#include <algorithm>

namespace livegs {

AssetCall::AssetCall(std::shared_ptr<const AssetBytes> asset, uint64_t offset)
    : asset_(std::move(asset)), offset_(offset) {
  if (!asset_) {
    Finish({grpc::StatusCode::NOT_FOUND,
            "asset_hash: is not an asset of the scene; use a hash from the reply of Join"});
  } else if (offset_ > asset_->bytes.size()) {
    Finish({grpc::StatusCode::OUT_OF_RANGE,
            "offset: is past the end of the asset, " + std::to_string(asset_->bytes.size()) + " bytes"});
  } else {
    write_next();
  }
}

void AssetCall::write_next() {
  const std::vector<std::byte>& bytes = asset_->bytes;
  if (offset_ == bytes.size()) {
    Finish(grpc::Status::OK);
    return;
  }
  const size_t length = std::min<size_t>(kAssetChunkBytes, bytes.size() - offset_);
  chunk_.set_offset(offset_);
  chunk_.set_total_bytes(bytes.size());
  chunk_.set_data(bytes.data() + offset_, length);
  offset_ += length;
  StartWrite(&chunk_);
}

void AssetCall::OnWriteDone(bool ok) {
  if (ok)
    write_next();
  else
    Finish(grpc::Status::CANCELLED);
}

}  // namespace livegs
