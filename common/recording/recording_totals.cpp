// SPDX-License-Identifier: Apache-2.0
#include "recording/recording_totals.h"

#include <span>

#include "wire/rest_body_codec.h"

namespace livegs {

int64_t tick_time_ns(uint64_t tick, double rate_hz) {
  const double time_ns = rate_hz > 0 ? static_cast<double>(tick) / rate_hz * 1e9 : 0.0;
  return time_ns < 9e18 ? static_cast<int64_t>(time_ns) : 0;
}

void RecordingCount::take(const v1::SessionEvent& event) {
  if (event.has_object_removed()) {
    totals_.set_objects_removed(totals_.objects_removed() + 1);
    revisions_.erase(event.object_removed().object_id());
    return;
  }
  const bool added = event.has_object_added();
  if (!added && !event.has_object_changed()) return;
  const v1::ObjectDescription& object = added ? event.object_added() : event.object_changed();
  const auto rest = decode_rest_body(std::as_bytes(std::span(object.rest_body())));
  uint32_t& revision = revisions_[object.object_id()];
  const uint32_t now = rest ? rest->revision : revision;
  if (added) totals_.set_objects_added(totals_.objects_added() + 1);
  if (!added && now > revision) totals_.set_breaks(totals_.breaks() + 1);
  revision = now;
}

void RecordingCount::take(const TickRecord& record, int64_t simulated_ns) {
  if (record.key && totals_.ticks() == 0) {
    totals_.set_first_tick(record.tick);
    totals_.set_first_ns(simulated_ns);
  }
  if (record.key || totals_.ticks() > 0) {
    totals_.set_last_tick(record.tick);
    totals_.set_last_ns(simulated_ns);
    totals_.set_ticks(totals_.ticks() + 1);
  }
  totals_.set_frames(totals_.frames() + (record.frame.empty() ? 0 : 1));
  totals_.set_resets(totals_.resets() + (record.scene ? 1 : 0));
  totals_.set_changes(totals_.changes() + record.actions.changes.size());
  uint64_t inputs = 0;
  for (const SessionSamples& one : record.actions.samples) inputs += one.samples.size();
  totals_.set_inputs(totals_.inputs() + inputs);
}

}  // namespace livegs
