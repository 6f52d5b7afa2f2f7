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

// What waits to be written may hold this much; a disk that is further behind ends the recording, never the
// session.
inline constexpr size_t kMaxQueuedBytes = 256u << 20;

// What was done since the scene was built may hold this much: about two hours of two tracked hands. A
// recording that begins later than that cannot be simulated again.
inline constexpr size_t kMaxHistoryBytes = 64u << 20;

struct RecordingOptions {
  bool inputs_only = false;  // no frames: it can be simulated again, not watched
  // With what objects are drawn with, so that it can be watched anywhere, and with the files that the scene
  // was built from, as they are when the recording begins, so that it can be simulated again anywhere.
  bool assets = false;
};

// Records the session that runs into a file (proto/recording_format.md), on a thread of its own: a tick never
// waits for the disk. A full disk ends the recording with one line; what was written can be read. What was
// done before a recording began is kept and written into it first, so that it can be simulated again from the
// beginning. Any thread, but for record(), which is the simulation's.
class SessionRecorder final : public TickRecorder {
 public:
  // `assets` outlives the recorder.
  explicit SessionRecorder(AssetStore& assets, size_t max_history_bytes = kMaxHistoryBytes);
  ~SessionRecorder() override;  // ends a recording in order

  // From the next tick on. InvalidArgument when the file is there already or cannot be made, or one is being
  // written.
  Result<void> start(const std::filesystem::path& path, const RecordingOptions& options = {});
  // Writes what waits, and the index; waits for it, three seconds at most. NotFound when none is being
  // written.
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

  // Ticks that had anything to say, as encode_tick() has them, since the first; the simulation's thread only.
  // Full blocks are shared with the recording that begins, so that a tick copies one at most.
  using Block = std::vector<std::vector<std::byte>>;
  using Blocks = std::vector<std::shared_ptr<const Block>>;
  static constexpr size_t kTicksPerBlock = 256;
  struct History {
    v1::SceneSource scene;  // that the first tick began with
    bool begun = false, whole = true;
    Blocks full;
    Block open;
    size_t bytes = 0;
    SamplesBefore samples;
  };
  const size_t max_history_bytes_;
  History history_;

  AssetStore& assets_;
  mutable std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable changed_;
  std::unique_ptr<Session> session_;  // while one is written; its file is the thread's alone
  uint64_t sessions_ = 0;             // so far: a tick goes to the one that it was made for
  std::deque<std::unique_ptr<Job>> waiting_;
  size_t waiting_bytes_ = 0;
  bool begins_ = false;   // with the next tick
  bool ends_ = false;     // when all that waits is written
  bool closing_ = false;  // so does the thread
  v1::RecordingStatus status_;
  std::thread thread_;
};

}  // namespace livegs
