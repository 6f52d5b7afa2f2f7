// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frames/send_budget.h"

#include <algorithm>

namespace livegs {
namespace {

// Shortest wait of a fetch; timers are not more precise.
constexpr int64_t kMinWait_ns = 1'000'000;

}  // namespace

void SendBudget::set_cap(double bytes_s) {
  std::lock_guard lock(mutex_);
  cap_bytes_s_ = bytes_s;
  bytes_.set_rate(bytes_s, bytes_s * kBurst_s);
}

bool SendBudget::capped() const {
  std::lock_guard lock(mutex_);
  return capped_now();
}

double SendBudget::available_bytes(int64_t now_ns) {
  std::lock_guard lock(mutex_);
  return capped_now() ? bytes_.refill(now_ns) : std::numeric_limits<double>::infinity();
}

void SendBudget::pay(double bytes) {
  std::lock_guard lock(mutex_);
  if (capped_now()) bytes_.pay(bytes);
}

SendBudget::Turn SendBudget::take_turn(const void* fetch, size_t max_bytes, int64_t now_ns) {
  std::lock_guard lock(mutex_);
  if (!capped_now()) {
    std::erase(waiting_, fetch);
    return {max_bytes, 0};
  }
  if (waiting_.empty()) waiting_since_ns_ = now_ns;
  auto place = std::find(waiting_.begin(), waiting_.end(), fetch);
  if (place == waiting_.end()) place = waiting_.insert(waiting_.end(), fetch);
  const auto before = static_cast<double>(place - waiting_.begin());

  const double full = cap_bytes_s_ * kBurst_s;
  const double chunk =
      std::min(full * kChunkShare, static_cast<double>(max_bytes + kChunkOverhead));  // with its overhead
  const double spare = bytes_.refill(now_ns) - full * kFrameShare;
  const int64_t overdue_ns = waiting_since_ns_ + kMaxAssetWait_ns;
  if (before == 0 && (spare >= chunk || now_ns >= overdue_ns)) {
    const double paid = std::max(chunk, spare);
    const size_t bytes = std::clamp<size_t>(
        static_cast<size_t>(std::max(paid - static_cast<double>(kChunkOverhead), 1.0)), 1, max_bytes);
    bytes_.pay(static_cast<double>(bytes + kChunkOverhead));
    waiting_.pop_front();
    waiting_since_ns_ = now_ns;
    return {bytes, 0};
  }
  const auto refilled_ns = static_cast<int64_t>((chunk * (before + 1) - spare) / cap_bytes_s_ * 1e9);
  return {0, std::clamp(std::min(refilled_ns, overdue_ns - now_ns), kMinWait_ns, kMaxAssetWait_ns)};
}

void SendBudget::leave(const void* fetch) {
  std::lock_guard lock(mutex_);
  std::erase(waiting_, fetch);
}

}  // namespace livegs
