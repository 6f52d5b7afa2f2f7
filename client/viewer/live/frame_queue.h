// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/assets/progressive_objects.h"

namespace livegs {

// Queue between a stream and a renderer that shows the present. The oldest unread frames are dropped, events
// never.
class FrameQueue final : public StreamSink {
 public:
  // `wake` is called on the session's threads after each update; it must not call this object.
  explicit FrameQueue(
      ProgressiveObjects& objects, std::function<void()> wake = [] {})
      : objects_(objects), wake_(std::move(wake)) {}

  // Called on the session's threads.
  void on_lost(const std::string& reason) override;
  void on_resumed(const ResumedSession& resumed) override;
  void on_frame(ReceivedFrame frame) override;
  void on_object_added(StreamedObject object) override;
  void on_object_changed(StreamedObject object) override;
  void on_object_removed(uint32_t object_id) override;
  void on_draining(const std::string& reason) override;
  void on_moving(const std::string& reason, const std::string& address) override;

  // Renderer thread: returns updates since the last call, events first, and refinements of partial assets.
  // Never blocks. New or fractured objects are fetched and bound on a worker thread and appear in a later
  // call; until then new objects are hidden and fractured ones keep their previous state. A restarted server
  // becomes visible once its first frame and all its objects are available, so that the last picture can be
  // drawn until then.
  struct StreamUpdate {
    std::vector<ReceivedFrame> frames;      // oldest first
    bool server_restarted = false;          // the frames are from a restarted server
    std::vector<StreamedObject> described;  // added or changed
    std::vector<uint32_t> removed;
    std::vector<uint32_t> refined;               // refined objects, whose kernels are renumbered
    std::optional<std::string> shutdown_reason;  // the server has announced its shutdown
    std::optional<std::string> lost;             // reason of a lost stream
    bool back = false;                           // the frames are the first after a reconnect
  };
  Result<StreamUpdate> take(SceneView& view);
  // Whether objects are being bound, so that take() should be called soon. Renderer thread.
  bool binds() const { return !pending_.empty() || objects_.progress().objects > 0; }
  // Objects that were there when the client joined: hidden ones are left out of all frames, as those are that
  // an event describes so. Renderer thread.
  void hide(std::span<const StreamedObject> joined);

  // Starts or stops keeping every frame for a recording.
  void record_frames(bool keep);
  std::vector<ReceivedFrame> take_recorded();

 private:
  using Binding = ProgressiveObjects::Binding;
  static constexpr size_t kMaxFrames = 32;
  struct Event {
    std::optional<StreamedObject> object;
    bool added = false;
    uint32_t id = 0;
  };
  // Waiting to be added to the view.
  struct Pending {
    Event event;
    std::future<Result<Binding>> bound;  // for objects that need a binding
    bool ready() const;
  };
  void take_event(Event event, const SceneView& view);
  Result<void> show(Pending pending, SceneView& view, StreamUpdate& update);

  // Appends under the lock, then wakes the renderer.
  template <class Change>
  void update(Change change) {
    {
      std::lock_guard lock(mutex_);
      change();
    }
    wake_();
  }

  ProgressiveObjects& objects_;
  const std::function<void()> wake_;
  std::deque<Pending> pending_;  // renderer thread; in the order of events
  // Renderer thread: bindings of objects that were removed before they were ready.
  std::vector<std::future<Result<Binding>>> unwanted_;
  std::set<uint32_t> hidden_;  // renderer thread
  std::mutex mutex_;           // guards everything below
  std::vector<Event> events_;
  size_t events_to_take_ = 0;  // events from before a server restart
  bool holds_ = false;         // holds the other events back until the next frame
  bool lost_ = false;
  StreamUpdate update_;
  bool records_frames_ = false;
  std::vector<ReceivedFrame> recorded_;
};

}  // namespace livegs
