// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "core/clock.h"
#include "stream/replay/playback_queue.h"
#include "stream/session/scripted_hands.h"
#include "stream/session/session_client.h"
#include "viewer/assets/asset_library.h"
#include "viewer/output/frame_log.h"

namespace livegs {

// Receives the stream of an offscreen client on the reader's thread: logs every frame, plays the script, and
// queues frames for the drawing thread.
class OffscreenSink final : public StreamSink {
 public:
  // All arguments must outlive the last call. The recording is done `seconds` after the first frame, or
  // slightly later if no frame arrives then, and also if none arrives within patience_s(). 0: never.
  OffscreenSink(SessionClient& client, AssetLibrary& assets, PlaybackQueue& queue, ReceivedLog log,
                double seconds)
      : client_(client), assets_(assets), queue_(queue), log_(std::move(log)), seconds_(seconds) {}

  void on_lost(const std::string& reason) override;
  void on_resumed(const ResumedSession& resumed) override;
  void on_frame(ReceivedFrame frame) override;
  void on_object_added(StreamedObject object) override;
  void on_object_changed(StreamedObject object) override;
  void on_object_removed(uint32_t object_id) override;
  void on_draining(const std::string& reason) override;

  // Starts the script. Objects are identified by name and size; their drivers give the position.
  struct Target {
    uint32_t object_id = 0;
    double size_m = 0;
  };
  void begin_script(ScriptedHands hands, std::map<std::string, Target> targets);

  // Waits up to `seconds` until the recording is done or the server shuts down. Returns whether it is done.
  bool wait_done(double seconds);
  double patience_s() const { return std::max(seconds_, kFirstFrameTimeout_s); }
  bool gave_up() const;  // no frame arrived
  std::string draining_reason() const;
  // Number of outages and the time until the session was resumed.
  struct Outages {
    // `restarted` counts the resumed streams whose server was restarted.
    uint64_t count = 0, resumed = 0, restarted = 0;
    double seconds = 0;  // sum over the resumed
    std::string last_reason;
  };
  Outages outages() const;
  ReceivedLog::Summary summary() const;
  // Objects added or changed, by id, with their last description.
  std::map<uint32_t, StreamedObject> changed_objects() const;

 private:
  void play_script(const ReceivedFrame& frame);
  double time_s(const ReceivedFrame& frame) const;  // simulated, since the first frame

  SessionClient& client_;
  AssetLibrary& assets_;
  PlaybackQueue& queue_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  ReceivedLog log_;
  const double seconds_;
  int64_t first_ns_ = 0;
  int64_t first_tick_ = 0;    // in ticks of the current server
  int64_t last_ns_ = 0;       // arrival of the newest frame
  double last_time_s_ = 0;    // its time_s()
  bool ticks_reset_ = false;  // applies to the next frame
  Outages outages_;
  const int64_t made_ns_ = now_ns();
  bool done_ = false, gave_up_ = false;
  std::string draining_reason_;
  std::map<uint32_t, StreamedObject> changed_objects_;
  std::optional<ScriptedHands> hands_;
  std::map<std::string, Target> targets_;
};

}  // namespace livegs
