// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/recording/verify_recording.h"

#include <map>

#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "recording/driver_hash.h"
#include "session/recording/recorded_files.h"
#include "session/simulation/scene_run.h"
#include "wire/frame_stream.h"

namespace livegs {
namespace {

using Difference = Verification::Difference;
using Hashes = std::map<uint32_t, uint32_t>;

class Verifier {
 public:
  Verifier(RecordingReader& recording, std::filesystem::path folder)
      : recording_(recording), folder_(std::move(folder)) {}

  Result<Verification> run(const std::function<void(uint64_t tick)>& progress) {
    if (!recording_.start().whole()) {
      return invalid_argument(recording_.path().string() +
                              ": does not contain all inputs since the scene was built; to verify, record "
                              "from the first tick with livegs-server --record");
    }
    if (folder_.empty()) {
      auto unpacked = UnpackedFiles::unpack(recording_);
      if (!unpacked) return unpacked.error();
      if (!unpacked->empty()) files_.emplace(std::move(*unpacked));
    }
    auto scene = built(recording_.start().scene());
    if (!scene) return scene.error();
    run_.emplace(std::move(*scene));
    recording_.rewind();
    while (!seen_.difference) {
      auto item = recording_.next();
      if (!item) return item.error();
      if (!*item) break;
      if (const auto* event = std::get_if<RecordedEvent>(&**item)) {
        take(*event);
      } else {
        auto taken = take(std::get<TickRecord>(**item));
        if (!taken) return taken.error();
        if (progress) progress(run_->tick());
      }
    }
    return seen_;
  }

 private:
  Result<Scene> built(const v1::SceneSource& source) const {
    if (files_) return Scene::build_again(files_->placed(source), files_->folder());
    return Scene::build_again(source, folder_.empty() ? std::filesystem::path(source.folder()) : folder_);
  }

  void differ(uint64_t tick, uint32_t id, std::string what) {
    if (seen_.difference) return;
    const auto name = names_.find(id);
    seen_.difference = Difference{tick, id, name == names_.end() ? "" : name->second, std::move(what)};
  }

  void take(const RecordedEvent& recorded) {
    const v1::SessionEvent& event = recorded.event;
    if (event.has_object_removed()) hashes_.erase(event.object_removed().object_id());
    if (!event.has_object_added()) return;
    const v1::ObjectDescription& object = event.object_added();
    names_[object.object_id()] = object.name();
    added_[object.object_id()] = object.asset_hash();
  }

  const std::string& asset_name(const std::shared_ptr<const GaussianAsset>& asset) {
    std::string& name = asset_names_[asset];
    if (name.empty()) name = content_hash(encode_ply(*asset));
    return name;
  }

  // Checks that added objects have the recorded assets.
  void compare_assets(const std::vector<SceneObject>& objects, uint64_t tick) {
    for (const SceneObject& object : objects) {
      const auto recorded = added_.find(object.id);
      if (recorded == added_.end()) {
        names_[object.id] = object.name;
        differ(tick, object.id, "is not in the recording");
      } else if (asset_name(object.asset) != recorded->second) {
        differ(tick, object.id, "has a different asset");
      }
    }
  }

  Result<void> take(const TickRecord& record) {
    if (run_->tick() == 0) {
      const auto& objects = run_->scene().objects();
      // A recording that starts later may have more objects at its first tick; only the initial ones are
      // compared.
      if (record.key) compare_assets({objects.begin(), objects.end()}, 0);
      if (seen_.difference) return {};
    }
    while (run_->tick() + 1 < record.tick) {
      (void)run_->advance({});
      ++seen_.ticks;
    }
    if (record.scene) {
      auto scene = built(*record.scene);
      if (!scene) return scene.error();
      run_->replace(std::move(*scene));
    }
    TickActions actions = record.actions;
    if (files_)
      for (v1::SceneChange& change : actions.changes) change = files_->placed(std::move(change));
    const TickResult tick = run_->advance(actions);
    ++seen_.ticks;
    if (tick.drivers.tick != record.tick)
      return invalid_data(recording_.path().string() + ": ticks do not increase; copy the recording again");
    begun_ = begun_ || record.key;
    if (!begun_) return {};
    for (const ObjectHash& one : record.hashes) hashes_[one.object_id] = one.hash;
    Hashes now;
    for (const ObjectDrivers& object : tick.drivers.objects) now[object.object_id] = driver_hash(object);
    compare(hashes_, now, record.tick, "moves differently");
    if (!record.frame.empty()) return compare_frame(record, tick.drivers);
    return {};
  }

  void compare(const Hashes& recorded, const Hashes& now, uint64_t tick, const std::string& what) {
    for (const auto& [id, hash] : recorded) {
      const auto own = now.find(id);
      if (own == now.end())
        differ(tick, id, "is missing");
      else if (own->second != hash)
        differ(tick, id, what);
    }
    for (const auto& [id, hash] : now) {
      if (!recorded.contains(id)) differ(tick, id, "is not in the recording");
    }
  }

  Result<void> compare_frame(const TickRecord& record, const DriverFrame& drivers) {
    auto recorded = frames_.read(record.frame);
    if (!recorded) return recorded.error();
    written_ = encode_stream_frame(drivers, record.key ? nullptr : written_).next;
    Hashes was, now;
    for (const ObjectDrivers& object : recorded->objects) was[object.object_id] = driver_hash(object);
    for (const ObjectDrivers& object : frame_of(*written_).objects)
      now[object.object_id] = driver_hash(object);
    compare(was, now, record.tick, "has a different frame");
    ++seen_.frames;
    return {};
  }

  RecordingReader& recording_;
  const std::filesystem::path folder_;
  std::optional<UnpackedFiles> files_;  // embedded in the recording
  std::map<std::shared_ptr<const GaussianAsset>, std::string> asset_names_;
  std::optional<SceneRun> run_;
  bool begun_ = false;
  Hashes hashes_;  // as recorded
  StreamReader frames_;
  StreamBaselinePtr written_;
  std::map<uint32_t, std::string> names_, added_;  // by id: names, asset hashes
  Verification seen_;
};

}  // namespace

Result<Verification> verify_recording(RecordingReader& recording, const std::filesystem::path& folder,
                                      const std::function<void(uint64_t tick)>& progress) {
  return Verifier(recording, folder).run(progress);
}

}  // namespace livegs
