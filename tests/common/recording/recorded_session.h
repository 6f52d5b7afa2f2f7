// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numeric>

#include "recording/recording_reader.h"
#include "recording/recording_writer.h"
#include "wire/rest_body_codec.h"

// A synthetic session: a rolling sphere, a second sphere that exists from tick 400 to tick 600, and two
// hands.

namespace livegs::testing {

inline ObjectDrivers drivers_at(uint32_t id, uint64_t tick) {
  ObjectDrivers drivers;
  drivers.object_id = id;
  const double angle = 0.01 * static_cast<double>(tick) + id;
  drivers.poses.resize(1);
  drivers.poses[0].position_m = {std::sin(angle), 0.1 * id, std::cos(angle)};
  drivers.poses[0].orientation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX());
  return drivers;
}

inline bool second_is_there(uint64_t tick) { return tick >= 400 && tick < 600; }

inline DriverFrame frame_at(uint64_t tick) {
  DriverFrame frame;
  frame.tick = tick;
  frame.simulated_ns = static_cast<int64_t>(tick) * 11'111'111;
  frame.objects.push_back(drivers_at(1, tick));
  if (second_is_there(tick)) frame.objects.push_back(drivers_at(2, tick));
  return frame;
}

inline InputSample sample_at(uint64_t tick) {
  InputSample sample;
  sample.sequence = tick;
  sample.sampled_ns = 1'000'000'000 + static_cast<int64_t>(tick) * 11'112'345;
  sample.for_tick = tick;
  sample.hands[1].active = true;
  const auto x = static_cast<float>(std::sin(0.02 * static_cast<double>(tick)));
  sample.hands[1].aim.position_m = Eigen::Vector3f(x, 1.0f, 0.5f).cast<double>();
  sample.hands[1].trigger = tick % 50 < 25 ? 1.0f : 0.25f;
  return sample;
}

inline v1::SessionEvent added(uint32_t id) {
  v1::SessionEvent event;
  v1::ObjectDescription& object = *event.mutable_object_added();
  object.set_object_id(id);
  object.set_name("sphere " + std::to_string(id));
  object.set_asset_hash(std::string(64, static_cast<char>('0' + id)));
  RestBody rest;
  rest.kind = DriverKind::Rigid;
  rest.bodies.resize(1);
  const std::vector<std::byte> bytes = encode_rest_body(rest);
  object.set_rest_body(bytes.data(), bytes.size());
  return event;
}

inline v1::SessionEvent removed(uint32_t id) {
  v1::SessionEvent event;
  event.mutable_object_removed()->set_object_id(id);
  return event;
}

inline v1::RecordingStart start_of_recording(bool inputs_only = false) {
  v1::RecordingStart start;
  start.set_rate_hz(90);
  start.mutable_scene()->set_name("made up");
  start.set_inputs_only(inputs_only);
  return start;
}

// Writes ticks 1 to `ticks`.
inline Result<RecordingWriter> write_session(const std::filesystem::path& path, uint64_t ticks,
                                             bool inputs_only = false) {
  auto writer = RecordingWriter::create(path, start_of_recording(inputs_only));
  if (!writer) return writer;
  for (uint64_t tick = 1; tick <= ticks; ++tick) {
    Result<void> done;
    if (tick == 1) done = writer->add_event(tick, added(1));
    if (done && tick == 400) done = writer->add_event(tick, added(2));
    if (done && tick == 600) done = writer->add_event(tick, removed(2));
    if (!done) return done.error();
    const DriverFrame frame = frame_at(tick);
    RecordingWriter::Tick one;
    one.tick = tick;
    one.drivers = &frame;
    if (tick % 2 == 0) one.actions.samples.push_back({7, {sample_at(tick - 1), sample_at(tick)}});
    if (auto taken = writer->add_tick(std::move(one)); !taken) return taken.error();
  }
  return writer;
}

}  // namespace livegs::testing
