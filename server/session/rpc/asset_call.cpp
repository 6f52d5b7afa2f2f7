// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/asset_call.h"

#include <algorithm>
#include <chrono>

#include "core/clock.h"

namespace livegs {

AssetCall* AssetCall::start(const AssetStore& assets, const v1::FetchAssetRequest& request,
                            std::shared_ptr<SendBudget> budget, std::shared_ptr<ClientSession> session) {
  const uint64_t offset = request.offset();
  const std::shared_ptr<AssetCall> call(
      new AssetCall(assets, assets.find_bytes(request.asset_hash(), request.base_hash()), offset,
                    std::move(budget), std::move(session)));
  call->self_ = call;
  if (!call->bytes_) {
    call->Finish({grpc::StatusCode::NOT_FOUND,
                  request.base_hash().empty()
                      ? "asset_hash: is not an asset of the scene; use a hash from the reply of Join"
                      : "base_hash: the server has no edit of this asset; fetch the whole asset"});
  } else if (offset > call->bytes_->size()) {
    call->Finish({grpc::StatusCode::OUT_OF_RANGE, "offset: is past the end of the asset; use at most " +
                                                      std::to_string(call->bytes_->size())});
  } else {
    call->write_next();
  }
  return call.get();
}

void AssetCall::write_next() {
  const std::shared_ptr<AssetCall> kept = shared_from_this();  // Finish may release gRPC's reference
  const std::vector<std::byte>& bytes = *bytes_;
  if (offset_ == bytes.size()) {
    Finish(grpc::Status::OK);
    return;
  }
  const int64_t now = now_ns();
  if (session_) session_->fetches(now);
  const SendBudget::Turn turn =
      budget_->take_turn(this, std::min<size_t>(kAssetChunkBytes, bytes.size() - offset_), now);
  if (turn.bytes == 0) {
    std::lock_guard lock(mutex_);
    if (!cancelled_) {
      turn_.Set(std::chrono::system_clock::now() + std::chrono::nanoseconds(turn.wait_ns),
                [call = weak_from_this()](bool) {
                  if (const auto waiting = call.lock()) waiting->write_next();
                });
      return;
    }
  } else {
    chunk_.set_offset(offset_);
    chunk_.set_total_bytes(bytes.size());
    chunk_.set_data(bytes.data() + offset_, turn.bytes);
    offset_ += turn.bytes;
    assets_.count_sent(turn.bytes);
    StartWrite(&chunk_);
    return;
  }
  Finish(grpc::Status::CANCELLED);
}

void AssetCall::OnWriteDone(bool ok) {
  if (ok)
    write_next();
  else
    Finish(grpc::Status::CANCELLED);
}

void AssetCall::OnCancel() {
  std::lock_guard lock(mutex_);
  cancelled_ = true;
  turn_.Cancel();  // the timer fires at once
}

void AssetCall::OnDone() {
  budget_->leave(this);
  const std::shared_ptr<AssetCall> last_share = std::move(self_);
}

}  // namespace livegs
