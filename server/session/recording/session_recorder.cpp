// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/recording/session_recorder.h"

#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <exception>
#include <set>

#include "core/clock.h"
#include "core/log.h"
#include "recording/recording_writer.h"
#include "session/assets/describe_object.h"
#include "session/recording/recorded_files.h"
#include "session/support/version.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

// Time that stop() waits for the disk; the rest is written later.
constexpr std::chrono::seconds kStopTimeout{3};

}  // namespace

// One tick to write.
struct SessionRecorder::Job {
  TickActions actions;
  std::optional<v1::SceneSource> scene;  // scene that replaced the current one in this tick
  // First tick only: the start of the recording.
  bool begins = false, whole = false;
  v1::SceneSource begun_with;
  Blocks past;
  double rate_hz = 0;
  DriverFrame drivers;
  std::vector<SceneObject> added, changed;
  std::vector<uint32_t> removed;
  size_t bytes = 0;
};

// A recording in progress. Recorder thread only.
class SessionRecorder::Session {
 public:
  Session(std::filesystem::path path, RecordingOptions options, AssetStore& assets)
      : path_(std::move(path)), options_(options), assets_(assets) {}

  Result<void> write(Job& job) {
    return unless_thrown([&] { return write_tick(job); });
  }
  Result<void> finish() {
    return unless_thrown([&] { return writer_ ? writer_->finish() : Result<void>(); });
  }
  uint64_t bytes() const { return writer_ ? writer_->bytes() : 0; }
  const std::filesystem::path& path() const { return path_; }

 private:
  // Running out of memory ends the recording, as a full disk does. No index is written, since the last write
  // may be incomplete.
  template <typename Write>
  Result<void> unless_thrown(Write&& write) {
    if (thrown_) return *thrown_;
    try {
      return write();
    } catch (const std::exception& error) {
      thrown_ = Error{ErrorCode::Internal, error.what()};
      return *thrown_;
    }
  }
  Result<void> write_tick(Job& job) {
    if (job.begins) {
      if (auto begun = begin(job); !begun) return begun;
    }
    const uint64_t tick = job.drivers.tick;
    for (const uint32_t id : job.removed) {
      v1::SessionEvent event;
      event.mutable_object_removed()->set_object_id(id);
      if (auto done = writer_->add_event(tick, event); !done) return done;
    }
    for (const SceneObject& object : job.added) {
      v1::SessionEvent event;
      *event.mutable_object_added() = describe_object(object, assets_);
      if (auto done = add(tick, object, event); !done) return done;
    }
    for (const SceneObject& object : job.changed) {
      v1::SessionEvent event;
      *event.mutable_object_changed() = describe_object(object, assets_);
      if (auto done = add(tick, object, event); !done) return done;
    }
    if (auto held = embed(job.scene, job.actions.changes); !held) return held;
    RecordingWriter::Tick written;
    written.tick = tick;
    written.actions = std::move(job.actions);
    written.scene = std::move(job.scene);
    written.drivers = &job.drivers;
    return writer_->add_tick(std::move(written));
  }
  Result<void> begin(Job& job) {
    v1::RecordingStart start;
    start.set_livegs_version(kVersion);
    start.set_protocol_version(kProtocolVersion);
    const v1::SceneSource source = job.begun_with;
    start.mutable_scene()->Swap(&job.begun_with);
    start.set_rate_hz(job.rate_hz);
    start.set_started_unix_s(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now()));
    start.set_inputs_only(options_.inputs_only);
    start.set_whole(job.whole);
    auto writer = RecordingWriter::create(path_, start);
    if (!writer) return writer.error();
    writer_.emplace(std::move(*writer));
    if (auto held = embed(source, {}); !held) return held;
    SamplesBefore samples;
    for (const auto& block : job.past) {
      for (const std::vector<std::byte>& tick : *block) {
        if (options_.assets) {
          const auto past = decode_tick(tick, samples);
          if (!past) return past.error();
          if (auto held = embed(past->scene, past->actions.changes); !held) return held;
        }
        if (auto added = writer_->add_past(tick); !added) return added;
      }
    }
    return {};
  }
  // The files of a scene that begins, if any, and of edits.
  Result<void> embed(const std::optional<v1::SceneSource>& scene,
                     const std::vector<v1::SceneChange>& changes) {
    if (!options_.assets) return {};
    if (scene) {
      scene_folder_ = scene->folder();
      if (auto held = embed_files(*scene, files_, *writer_); !held) return held;
    }
    for (const v1::SceneChange& change : changes) {
      if (auto held = embed_files(source_of(change, scene_folder_), files_, *writer_); !held) return held;
    }
    return {};
  }
  Result<void> add(uint64_t tick, const SceneObject& object, const v1::SessionEvent& event) {
    if (options_.assets) {
      const auto asset = assets_.add(object.asset);
      if (held_.insert(asset->hash).second) {
        if (auto done = writer_->add_asset(asset->hash, asset->bytes); !done) return done;
      }
    }
    return writer_->add_event(tick, event);
  }

  const std::filesystem::path path_;
  const RecordingOptions options_;
  AssetStore& assets_;
  std::optional<RecordingWriter> writer_;
  std::optional<Error> thrown_;
  std::set<std::string> held_, files_;  // embedded assets by hash, embedded files by name
  std::string scene_folder_;            // of the current scene
};

SessionRecorder::SessionRecorder(AssetStore& assets, size_t max_history_bytes)
    : max_history_bytes_(max_history_bytes), assets_(assets) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "recorder");
    run();
  });
}

SessionRecorder::~SessionRecorder() {
  {
    std::lock_guard lock(mutex_);
    closing_ = ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

Result<void> SessionRecorder::start(const std::filesystem::path& path, const RecordingOptions& options) {
  if (path.empty()) return invalid_argument("recording: path is empty; give a file");
  if (path.extension() != ".lvgrec")
    return invalid_argument(path.string() + ": does not end in .lvgrec; choose a name that does");
  // Checked here rather than at the first tick, so that the caller gets the error.
  std::error_code error;
  if (std::filesystem::exists(path, error)) {
    return invalid_argument(path.string() + ": already exists; choose another name for the recording");
  }
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error)) {
    return invalid_argument(path.string() + ": cannot be created: the server has no folder " +
                            folder.string() + "; create it, or give another folder");
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    return invalid_argument(path.string() + ": cannot be created: the server may not write to " +
                            folder.string() + "; give another folder");
  }
  std::lock_guard lock(mutex_);
  if (session_)
    return invalid_argument("recording: is already in progress in " + session_->path().string() +
                            "; stop it with livegs ctl record stop");
  session_ = std::make_unique<Session>(path, options, assets_);
  ++sessions_;
  begins_ = true;
  ends_ = false;
  status_.Clear();
  status_.set_path(path.string());
  status_.set_recording(true);
  return {};
}

Result<v1::RecordingStatus> SessionRecorder::stop() {
  std::unique_lock lock(mutex_);
  if (!session_) {
    return not_found("recording: none is in progress" + (status_.message().empty()
                                                             ? "; start one with livegs ctl record start"
                                                             : "; " + status_.message()));
  }
  ends_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, kStopTimeout, [&] { return !session_; });
  return status_;
}

v1::RecordingStatus SessionRecorder::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

size_t SessionRecorder::bytes_of(const TickResult& tick) {
  size_t bytes = sizeof(Job);
  for (const ObjectDrivers& object : tick.drivers.objects) {
    bytes += sizeof(ObjectDrivers) + object.poses.size() * sizeof(Pose) +
             object.positions_m.size() * sizeof(Eigen::Vector3f) +
             object.rotations.size() * sizeof(Eigen::Quaternionf);
  }
  return bytes;
}

void SessionRecorder::append_history(const TickActions& actions, const TickResult& tick, const Scene& scene) {
  if (!std::exchange(history_.begun, true)) {
    history_.scene = scene.source();
    history_.whole = tick.drivers.tick == 1 && !tick.scene_is_new;
  }
  const bool says = !actions.empty() || !actions.stepped || tick.scene_is_new;
  if (!says || !history_.whole) return;
  TickRecord record;
  record.tick = tick.drivers.tick;
  record.actions = actions;
  if (tick.scene_is_new) record.scene = scene.source();
  history_.open.push_back(encode_tick(record, history_.samples));
  history_.bytes += history_.open.back().size();
  if (history_.open.size() == kTicksPerBlock)
    history_.full.push_back(std::make_shared<const Block>(std::exchange(history_.open, {})));
  if (history_.bytes <= max_history_bytes_) return;
  history_.whole = false;
  history_.open = {};
  history_.full = {};
  log_info("recording: the input history is full; recordings that start from now on cannot be verified");
}

void SessionRecorder::record(const TickActions& taken, const TickResult& tick, const Scene& scene) {
  TickActions actions = taken;
  actions.cuts = tick.cuts;
  bool begins = false, writes = false;
  uint64_t session = 0;
  {
    std::lock_guard lock(mutex_);
    session = sessions_;
    writes = session_ && !ends_;
    begins = writes && std::exchange(begins_, false);
  }
  auto job = writes ? std::make_unique<Job>() : nullptr;
  if (begins) {
    job->begins = true;
    job->past = history_.full;
    job->past.push_back(std::make_shared<const Block>(history_.open));
    job->begun_with = history_.begun ? history_.scene : scene.source();
    job->whole = history_.begun ? history_.whole : tick.drivers.tick == 1 && !tick.scene_is_new;
  }
  append_history(actions, tick, scene);
  if (!writes) return;
  job->actions = std::move(actions);
  job->rate_hz = scene.world().settings().rate_hz;
  if (tick.scene_is_new) job->scene = scene.source();
  job->drivers = tick.drivers;
  if (begins) {
    job->added.assign(scene.objects().begin(), scene.objects().end());
  } else {
    job->added = tick.added;
    job->changed = tick.changed;
    job->removed = tick.removed;
  }
  job->bytes = bytes_of(tick);
  {
    std::lock_guard lock(mutex_);
    if (!session_ || ends_ || sessions_ != session) return;
    waiting_bytes_ += job->bytes;
    waiting_.push_back(std::move(job));
    if (waiting_bytes_ > kMaxQueuedBytes) fail("the disk is too slow; record to a faster disk");
  }
  changed_.notify_all();
}

// mutex_ must be held. Drops waiting ticks; the thread then ends the recording.
void SessionRecorder::fail(const std::string& why) {
  waiting_.clear();
  waiting_bytes_ = 0;
  ends_ = true;
  if (!status_.message().empty()) return;
  status_.set_message("recording: ended at tick " + std::to_string(status_.last_tick()) + ": " + why);
}

void SessionRecorder::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return !waiting_.empty() || (ends_ && session_) || closing_; });
    if (!waiting_.empty()) {
      const std::unique_ptr<Job> job = std::move(waiting_.front());
      waiting_.pop_front();
      waiting_bytes_ -= job->bytes;
      Session& session = *session_;
      lock.unlock();
      auto written = session.write(*job);
      lock.lock();
      if (!written) {
        fail(written.error().message + " (the session continues)");
      } else {
        status_.set_ticks(status_.ticks() + 1);
        status_.set_last_tick(job->drivers.tick);
        status_.set_bytes(session.bytes());
      }
      continue;
    }
    if (ends_ && session_) {
      Session& session = *session_;
      lock.unlock();
      const auto finished = session.finish();
      lock.lock();
      if (!finished && status_.message().empty())
        fail(finished.error().message + " (the recorded part can be read)");
      status_.set_bytes(session.bytes());
      status_.set_recording(false);
      if (!status_.message().empty())
        log_warn("%s", status_.message().c_str());
      else
        log_info("recorded %s: %llu ticks, %.1f MB", session.path().c_str(),
                 static_cast<unsigned long long>(status_.ticks()),
                 static_cast<double>(status_.bytes()) * 1e-6);
      session_.reset();
      changed_.notify_all();
    }
    if (closing_) return;
  }
}

}  // namespace livegs
