// SPDX-License-Identifier: Apache-2.0
#include "stream/replay/recording_playback.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/clock.h"

namespace livegs {

Result<RecordingPlayback> RecordingPlayback::open(const std::filesystem::path& path) {
  auto recording = RecordingReader::open(path);
  if (!recording) return recording.error();
  if (recording->start().inputs_only()) {
    return invalid_argument(
        path.string() +
        ": the recording has no frames and cannot be shown; simulate it with livegs ctl replay --verify");
  }
  RecordingPlayback playback(std::move(*recording));
  if (auto sought = playback.seek(0); !sought) return sought.error();
  return playback;
}

double RecordingPlayback::length_s() const {
  return seconds_from_ns(recording_.totals().last_ns() - recording_.totals().first_ns());
}

void RecordingPlayback::follow(const v1::SessionEvent& event,
                               std::map<uint32_t, v1::ObjectDescription>& described) {
  if (event.has_object_removed()) {
    described.erase(event.object_removed().object_id());
  } else if (event.has_object_added() || event.has_object_changed()) {
    const v1::ObjectDescription& object =
        event.has_object_added() ? event.object_added() : event.object_changed();
    described[object.object_id()] = object;
  }
}

Result<StreamItem> RecordingPlayback::item(const v1::SessionEvent& event) {
  if (event.has_object_removed()) {
    known_.remove(event.object_removed().object_id());
    return StreamItem(ObjectRemoved{event.object_removed().object_id()});
  }
  auto object = known_.take(event.has_object_added() ? event.object_added() : event.object_changed());
  if (!object) return object.error();
  if (event.has_object_added()) return StreamItem(ObjectAdded{std::move(*object)});
  return StreamItem(ObjectChanged{std::move(*object)});
}

Result<ReceivedFrame> RecordingPlayback::frame(const TickRecord& record) {
  auto drivers = frames_.read(record.frame);
  if (!drivers) return drivers.error();
  ReceivedFrame frame;
  frame.tick = record.tick;
  frame.bytes = record.frame.size();
  frame.received_ns = frame.decoded_ns = now_ns();
  frame.run.set_paused(!record.actions.stepped);
  frame.run.set_simulated_s(seconds_from_ns(drivers->simulated_ns));
  frame.drivers = std::make_shared<const DriverFrame>(std::move(*drivers));
  return frame;
}

// A seek may go back before a fracture: objects that differ are removed and added again.
Result<void> RecordingPlayback::take_difference(const std::map<uint32_t, v1::ObjectDescription>& described) {
  std::vector<const v1::ObjectDescription*> now;
  for (const auto& [id, description] : described) now.push_back(&description);
  auto difference = known_.replace(now);
  if (!difference) return difference.error();
  for (const uint32_t id : difference->removed) waiting_.push_back(ObjectRemoved{id});
  for (StreamedObject& object : difference->changed) {
    waiting_.push_back(ObjectRemoved{object.id});
    waiting_.push_back(ObjectAdded{std::move(object)});
  }
  for (StreamedObject& object : difference->added) waiting_.push_back(ObjectAdded{std::move(object)});
  return {};
}

Result<void> RecordingPlayback::seek(double seconds) {
  error_.reset();
  // Additions and removals stay queued, since the next difference starts from them; frames are dropped.
  std::erase_if(waiting_, [](const StreamItem& item) { return std::holds_alternative<ReceivedFrame>(item); });
  decoded_ = 0;
  const double length_ns = 1e9 * std::max(0.0, std::min(std::isfinite(seconds) ? seconds : 0.0, length_s()));
  const int64_t moment_ns = recording_.totals().first_ns() + static_cast<int64_t>(length_ns);
  auto objects = recording_.seek(moment_ns);
  if (!objects) return objects.error();
  std::map<uint32_t, v1::ObjectDescription> described;
  for (v1::ObjectDescription& object : *objects) described[object.object_id()] = std::move(object);
  frames_ = {};
  std::optional<ReceivedFrame> last;
  for (;;) {
    auto next = recording_.next();
    if (!next) return next.error();
    if (!*next) break;
    if (const auto* event = std::get_if<RecordedEvent>(&**next)) {
      follow(event->event, described);
      continue;
    }
    const auto& record = std::get<TickRecord>(**next);
    if (record.frame.empty()) continue;
    auto read = frame(record);
    if (!read) return read.error();
    ++decoded_;
    last = std::move(*read);
    // The next frame would be after it.
    if (last->drivers->simulated_ns +
            static_cast<int64_t>(1e9 / std::max(1.0, recording_.start().rate_hz())) >
        moment_ns)
      break;
  }
  if (!last)
    return invalid_data(recording_.path().string() +
                        ": no frame follows a key tick; copy the recording again");
  if (auto taken = take_difference(described); !taken) return taken;
  waiting_.push_back(std::move(*last));
  return {};
}

Result<std::optional<StreamItem>> RecordingPlayback::next() {
  for (;;) {
    auto next = recording_.next();
    if (!next) return next.error();
    if (!*next) return std::optional<StreamItem>();
    if (const auto* event = std::get_if<RecordedEvent>(&**next)) {
      if (event->event.kind_case() == v1::SessionEvent::KIND_NOT_SET || event->event.has_draining()) continue;
      auto made = item(event->event);
      if (!made) return made.error();
      return std::optional<StreamItem>(std::move(*made));
    }
    const auto& record = std::get<TickRecord>(**next);
    if (record.frame.empty()) continue;
    auto read = frame(record);
    if (!read) return read.error();
    return std::optional<StreamItem>(StreamItem(std::move(*read)));
  }
}

std::optional<StreamItem> RecordingPlayback::take() {
  if (!waiting_.empty()) {
    StreamItem item = std::move(waiting_.front());
    waiting_.pop_front();
    return item;
  }
  if (error_) return std::nullopt;
  auto taken = next();
  if (!taken) {
    error_ = taken.error();
    return std::nullopt;
  }
  return std::move(*taken);
}

}  // namespace livegs
