// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <future>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/assets/progressive_objects.h"

namespace livegs {

// What a stream brought, for a drawer that shows the present: of frames that were not taken in time the
// oldest are dropped, events never.
class FrameQueue final : public StreamSink {
 public:
  explicit FrameQueue(ProgressiveObjects& objects) : objects_(objects) {}

  // On the session's threads.
  void on_lost(const std::string& reason) override;
  void on_resumed(const ResumedSession& resumed) override;
  void on_frame(ReceivedFrame frame) override;
  void on_object_added(StreamedObject object) override;
  void on_object_changed(StreamedObject object) override;
  void on_object_removed(uint32_t object_id) override;
  void on_draining(const std::string& reason) override;

  // On the drawer's: what came since the last call, events first, and more of assets that are being fetched.
  // It waits for nothing: an object that is new, or broke, is fetched and tied to its drivers on a thread of
  // its own and comes, with its first kernels, with a later call; until then a new one is not seen, and one
  // that broke stands as it was. A server that was started anew shows itself when its first frame and all of
  // its objects are there, so that the last picture can still be drawn.
  struct StreamUpdate {
    std::vector<ReceivedFrame> frames;      // oldest first
    bool anew = false;                      // they are of a server that was started anew
    std::vector<StreamedObject> described;  // added or changed
    std::vector<uint32_t> removed;
    std::vector<uint32_t> refined;  // more of their kernels have come: kernels have other numbers
    std::optional<std::string> goodbye;
    std::optional<std::string> lost;  // why the stream is gone
    bool back = false;                // the frames are the first of a stream that came back
  };
  Result<StreamUpdate> take(SceneView& view);

  // From now on every frame is kept, too, for a recording; or no longer.
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
  // On its way to the view.
  struct Pending {
    Event event;
    std::future<Result<Binding>> bound;  // of one that has to be
    bool ready() const;
  };
  void take_event(Event event, const SceneView& view);
  Result<void> show(Pending pending, SceneView& view, StreamUpdate& update);

  ProgressiveObjects& objects_;
  std::deque<Pending> pending_;  // the drawer's, in the order of events
  std::vector<std::future<Result<Binding>>>
      unwanted_;      // its as well: of objects that went before they were there
  std::mutex mutex_;  // guards everything below
  std::vector<Event> events_;
  size_t events_to_take_ = 0;  // those of before such a server
  bool holds_ = false;         // the others, until the next frame
  bool lost_ = false;
  StreamUpdate update_;
  bool records_frames_ = false;
  std::vector<ReceivedFrame> recorded_;
};

}  // namespace livegs
