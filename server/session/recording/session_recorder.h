// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"
#include "livegs/v1/admin.pb.h"
#include "session/assets/asset_store.h"
#include "session/tick/tick_result.h"

namespace livegs {

// Bytes of ticks that may wait to be written. A disk that lags further behind ends the recording, not the
// session.
inline constexpr size_t kMaxQueuedBytes = 256u << 20;

// Bytes of input history since the scene was built: about two hours of two tracked hands. A recording that
// starts after more than that cannot be verified.
inline constexpr size_t kMaxHistoryBytes = 64u << 20;

struct RecordingOptions {
  bool inputs_only = false;  // no frames: can be verified, not played
  // Also embeds the assets, for playing anywhere, and the files of the scene as they are at the start and of
  // edits as they are in their tick, for verifying anywhere.
  bool assets = false;
};

// Records the running session into a file (proto/recording_format.md) on its own thread, so that ticks do not
// wait for the disk. A full disk ends the recording with one log line; the file stays readable. Inputs from
// before the start are kept and written first, so that the session can be simulated from its beginning. Any
// thread, except for record(), which is for the simulation thread.
class SessionRecorder final : public TickRecorder {
 public:
  // `assets` outlives the recorder.
  explicit SessionRecorder(AssetStore& assets, size_t max_history_bytes = kMaxHistoryBytes);
  ~SessionRecorder() override;  // finishes a recording

  // Starts at the next tick. InvalidArgument if the file already exists or cannot be created, or if a
  // recording is in progress.
  Result<void> start(const std::filesystem::path& path, const RecordingOptions& options = {});
  // Writes the waiting ticks and the index; blocks for at most three seconds. NotFound if no recording is in
  // progress.
  Result<v1::RecordingStatus> stop();
  v1::RecordingStatus status() const;

  void record(const TickActions& actions, const TickResult& tick, const Scene& scene) override;

 private:
  struct Job;
  class Session;
  void run();
  static size_t bytes_of(const TickResult& tick);
  void fail(const std::string& why);
  void append_history(const TickActions& actions, const TickResult& tick, const Scene& scene);

  // Encoded ticks with actions since the first tick; simulation thread only. Full blocks are shared with a
  // new recording, so that its first tick copies at most one block.
  using Block = std::vector<std::vector<std::byte>>;
  using Blocks = std::vector<std::shared_ptr<const Block>>;
  static constexpr size_t kTicksPerBlock = 256;
  struct History {
    v1::SceneSource scene;  // initial scene
    bool begun = false, whole = true;
    Blocks full;
    Block open;
    size_t bytes = 0;
    SamplesBefore samples;
  };
  const size_t max_history_bytes_;
  History history_;

  AssetStore& assets_;
  mutable std::mutex mutex_;  // guards everything below except the thread
  std::condition_variable changed_;
  std::unique_ptr<Session>
      session_;            // recording in progress, or null; its file is accessed by the thread only
  uint64_t sessions_ = 0;  // recordings so far: a tick belongs to one of them
  std::deque<std::unique_ptr<Job>> waiting_;
  size_t waiting_bytes_ = 0;
  bool begins_ = false;   // start with the next tick
  bool ends_ = false;     // end when all waiting ticks are written
  bool closing_ = false;  // end the thread as well
  v1::RecordingStatus status_;
  std::thread thread_;
};

}  // namespace livegs
