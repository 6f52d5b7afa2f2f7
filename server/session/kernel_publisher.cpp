// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/kernel_publisher.h"

#include <pthread.h>

#include <utility>

#include "core/serial_here.h"

namespace livegs {

KernelPublisher::KernelPublisher(SessionTable& table) : table_(table) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "kernels");
    set_serial_here(true);  // the cores are the simulation's
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

void KernelPublisher::publish(std::shared_ptr<PublishedTick> tick, std::span<const SceneObject> added,
                              std::span<const SceneObject> changed, std::span<const uint32_t> removed) {
  const bool wanted = table_.wants(v1::JoinRequest::KERNELS) || table_.wants(v1::JoinRequest::KERNELS_EXACT);
  if (!wanted && added.empty() && changed.empty() && removed.empty()) return;
  {
    std::lock_guard lock(mutex_);
    objects_.insert(objects_.end(), added.begin(), added.end());
    objects_.insert(objects_.end(), changed.begin(), changed.end());
    removed_.insert(removed_.end(), removed.begin(), removed.end());
    waiting_ = std::move(tick);
  }
  changed_.notify_one();
}

void KernelPublisher::run() {
  for (;;) {
    std::shared_ptr<PublishedTick> tick;
    std::vector<SceneObject> objects;
    std::vector<uint32_t> removed;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || waiting_; });
      if (stopping_) return;
      tick = std::exchange(waiting_, nullptr);
      objects = std::exchange(objects_, {});
      removed = std::exchange(removed_, {});
    }
    for (const SceneObject& object : objects) poser_.take(object);
    for (const uint32_t id : removed) poser_.remove(id);
    for (const auto& [asked, encoding] : {std::pair{v1::JoinRequest::KERNELS, KernelEncoding::Quantised},
                                          {v1::JoinRequest::KERNELS_EXACT, KernelEncoding::Exact}}) {
      if (!table_.wants(asked)) continue;
      tick->keep(asked, encode_kernels(poser_.pose(tick->drivers(), encoding), encoding));
      table_.deliver_kernels(tick, asked);
    }
  }
}

}  // namespace livegs
