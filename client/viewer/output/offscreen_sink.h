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

// What an offscreen client does with its stream, on the reader's thread: logs every frame, plays the script
// against it, and puts it into the queue of the thread that draws.
class OffscreenSink final : public StreamSink {
 public:
  // All outlive the recorder's last call. `seconds` after the first frame the recording is done, or a little
  // later where none comes then; and so it is when there was none for patience_s(). 0: never.
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

  // From now on the hands move. An object is known by its name and its size; where it is, its drivers say.
  struct Target {
    uint32_t object_id = 0;
    double size_m = 0;
  };
  void begin_script(ScriptedHands hands, std::map<std::string, Target> targets);

  // Waits, at most so long, until the recording is done or the server drains. True when it is.
  bool wait_done(double seconds);
  double patience_s() const { return std::max(seconds_, kFirstFrameTimeout_s); }
  bool gave_up() const;  // no frame came
  std::string draining_reason() const;
  // How often the stream was gone, and the time until it was joined again.
  struct Outages {
    uint64_t count = 0, resumed = 0,
             restarted = 0;  // restarted: of the resumed, with a server that was started anew
    double seconds = 0;      // of the resumed
    std::string last_reason;
  };
  Outages outages() const;
  ReceivedLog::Summary summary() const;
  // Objects that came or changed, by id, as the server last described them.
  std::map<uint32_t, StreamedObject> changed_objects() const;

 private:
  void play_script(const ReceivedFrame& frame);
  double time_s(const ReceivedFrame& frame) const;  // of simulation, since the first frame

  SessionClient& client_;
  AssetLibrary& assets_;
  PlaybackQueue& queue_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  ReceivedLog log_;
  const double seconds_;
  int64_t first_ns_ = 0;
  int64_t first_tick_ = 0;    // in ticks of the server that is there now
  int64_t last_ns_ = 0;       // when the newest frame came
  double last_time_s_ = 0;    // and its time_s()
  bool ticks_reset_ = false;  // with the next frame
  Outages outages_;
  const int64_t made_ns_ = now_ns();
  bool done_ = false, gave_up_ = false;
  std::string draining_reason_;
  std::map<uint32_t, StreamedObject> changed_objects_;
  std::optional<ScriptedHands> hands_;
  std::map<std::string, Target> targets_;
};

}  // namespace livegs
