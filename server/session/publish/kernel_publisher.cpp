// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/publish/kernel_publisher.h"

#include <pthread.h>

#include <utility>

#include "core/clock.h"
#include "core/log.h"
#include "core/serial_here.h"

namespace livegs {
namespace {

// A warning is logged after this many consecutive frames that take this long.
constexpr int64_t kSlowFrame_ns = 100'000'000;
constexpr size_t kMaxSlowFrames = 3;

}  // namespace

KernelPublisher::KernelPublisher(SessionTable& table) : table_(table) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "kernels");
    set_serial_here(true);  // leaves the other cores to the simulation
    run();
  });
}

KernelPublisher::~KernelPublisher() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void KernelPublisher::begin_with(std::span<const SceneObject* const> objects) {
  std::lock_guard lock(mutex_);
  for (const SceneObject* object : objects) objects_.push_back(*object);
}

void KernelPublisher::take(std::span<const SceneObject> added, std::span<const SceneObject> changed,
                           std::span<const uint32_t> removed) {
  if (added.empty() && changed.empty() && removed.empty()) return;
  std::lock_guard lock(mutex_);
  objects_.insert(objects_.end(), added.begin(), added.end());
  objects_.insert(objects_.end(), changed.begin(), changed.end());
  removed_.insert(removed_.end(), removed.begin(), removed.end());
  taken_ = true;
}

void KernelPublisher::publish(std::shared_ptr<TickEncodings> tick) {
  const bool wanted = table_.has_clients_for(v1::JoinRequest::KERNELS) ||
                      table_.has_clients_for(v1::JoinRequest::KERNELS_EXACT);
  {
    std::lock_guard lock(mutex_);
    const bool news = std::exchange(taken_, false);
    if (!wanted && !news) return;
    waiting_ = std::move(tick);
  }
  changed_.notify_one();
}

// The first frame includes binding kernels to drivers, so one slow frame is not reported.
void KernelPublisher::note_time(int64_t took_ns, size_t bytes) {
  slow_ = took_ns > kSlowFrame_ns ? slow_ + 1 : 0;
  if (warned_ || slow_ < kMaxSlowFrames) return;
  warned_ = true;
  log_warn(
      "kernels: posing and encoding a frame of %.1f MB takes %.0f ms, which delays it; use driver frames for "
      "lower latency",
      1e-6 * static_cast<double>(bytes), milliseconds_from_ns(took_ns));
}

void KernelPublisher::run() {
  for (;;) {
    std::vector<SceneObject> objects;
    std::vector<uint32_t> removed;
    std::shared_ptr<TickEncodings> tick;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || waiting_; });
      if (stopping_) return;
      tick = std::exchange(waiting_, nullptr);
      objects.swap(objects_);
      removed.swap(removed_);
    }
    for (const SceneObject& object : objects) poser_.take(object);
    for (const uint32_t id : removed) poser_.remove(id);
    for (const auto& [asked, encoding] : {std::pair{v1::JoinRequest::KERNELS, KernelEncoding::Quantised},
                                          {v1::JoinRequest::KERNELS_EXACT, KernelEncoding::Exact}}) {
      if (!table_.has_clients_for(asked)) continue;
      const int64_t begun_ns = now_ns();
      std::vector<std::byte> frame = encode_kernels(poser_.pose(tick->drivers(), encoding), encoding);
      note_time(now_ns() - begun_ns, frame.size());
      tick->keep(asked, std::move(frame));
      table_.deliver_kernels(tick, asked);
    }
  }
}

}  // namespace livegs
