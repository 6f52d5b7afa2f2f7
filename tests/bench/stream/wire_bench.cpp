// SPDX-License-Identifier: Apache-2.0
// Time and bytes of encoding and decoding driver frames. Prints CSV: `wire_bench >
// results/<machine>/wire.csv`. Nodes of lattices are in rows with known neighbours; particles have random
// positions. Objects move like a twisted ball. 10 warm-up runs, 200 timed runs, on one thread, as the codec
// is single-threaded.
#include <cmath>
#include <cstdio>
#include <string_view>

#include "bench/support/arguments.h"
#include "bench/support/time_of.h"
#include "common/skin/kernels/rest_bodies.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"

using namespace livegs;
using namespace livegs::testing;

namespace {

constexpr int kEncodeGoal_ns = 30, kDecodeGoal_ns = 20;  // per driver

DriverFrame frame_of(DriverKind kind, size_t objects, size_t drivers, uint64_t seed) {
  std::mt19937_64 random(seed);
  DriverFrame frame;
  for (size_t i = 0; i < objects; ++i) {
    ObjectDrivers object;
    object.object_id = static_cast<uint32_t>(i + 1);
    object.kind = kind;
    const auto side = static_cast<size_t>(std::ceil(std::cbrt(static_cast<double>(drivers))));
    std::vector<Eigen::Vector3i> places;
    for (size_t d = 0; d < drivers; ++d) {
      Eigen::Vector3d at = uniform3(random, -0.5, 0.5);
      if (kind == DriverKind::Lattice) {
        places.emplace_back(d % side, d / side % side, d / side / side);
        at = places.back().cast<double>() / static_cast<double>(side) - Eigen::Vector3d::Constant(0.5);
      }
      if (kind == DriverKind::Rigid) {
        object.poses.push_back({at, random_rotation(random)});
      } else {
        object.positions_m.push_back(at.cast<float>());
        if (kind == DriverKind::Particles) object.rotations.push_back(random_rotation(random).cast<float>());
      }
    }
    if (kind == DriverKind::Lattice) object.neighbours = find_node_neighbours(std::move(places));
    frame.objects.push_back(object);
  }
  return frame;
}

// Frames of objects in strong motion: elastic ones swing and oscillate, rigid ones fall and tumble.
std::vector<DriverFrame> motion_of(DriverKind kind, size_t objects, size_t drivers, size_t frames) {
  std::vector<DriverFrame> motion;
  const DriverFrame rest = frame_of(kind, objects, drivers, 1);
  for (size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / 90.0;
    DriverFrame frame = rest;
    frame.tick = f + 1;
    for (ObjectDrivers& object : frame.objects) {
      const double phase = object.object_id;
      for (Eigen::Vector3f& at : object.positions_m) {
        const double swing =
            0.1 * std::sin(12.0 * t + 8.0 * at.y() + phase) + 0.02 * std::sin(60.0 * t + 20.0 * at.x());
        at += Eigen::Vector3d(swing, 0.4 * swing, 0.2 * std::cos(15.0 * t)).cast<float>();
      }
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(7.0 * t, Eigen::Vector3d(1, phase, 2).normalized()));
      for (Pose& pose : object.poses)
        pose = {pose.position_m - Eigen::Vector3d(0, 4.9 * t * t, t), turn * pose.orientation};
      for (Eigen::Quaternionf& rotation : object.rotations) rotation = turn.cast<float>() * rotation;
    }
    motion.push_back(std::move(frame));
  }
  return motion;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Time and bytes to encode and decode driver frames; CSV on standard output", "wire_bench");
  bench::read_arguments(app, argc, argv);
  struct Case {
    const char* kind;
    DriverKind driver_kind;
    size_t objects, drivers;
  };
  const std::vector<Case> cases = {
      {"rigid", DriverKind::Rigid, 20, 1},          {"rigid", DriverKind::Rigid, 200, 1},
      {"lattice", DriverKind::Lattice, 1, 500},     {"lattice", DriverKind::Lattice, 4, 3000},
      {"lattice", DriverKind::Lattice, 10, 5000},   {"particles", DriverKind::Particles, 1, 500},
      {"particles", DriverKind::Particles, 4, 3000}};
  std::printf(
      "kind,objects,drivers,stage,median_ms,p99_ms,ns_per_driver,goal_ns_per_driver,bytes,bytes_per_driver,"
      "mbit_s_at_90_hz\n");
  for (const Case& one : cases) {
    const DriverFrame frame = frame_of(one.driver_kind, one.objects, one.drivers, 1);
    const std::vector<std::byte> bytes = encode_frame(frame);
    const double all = static_cast<double>(one.objects * one.drivers);
    const auto report_bytes = [&](const char* stage, const bench::Times& times, size_t size) {
      const int goal_ns = std::string_view(stage).ends_with("encode") ? kEncodeGoal_ns : kDecodeGoal_ns;
      std::printf("%s,%zu,%zu,%s,%.4f,%.4f,%.1f,%d,%zu,%.2f,%.2f\n", one.kind, one.objects,
                  one.objects * one.drivers, stage, times.median_ms, times.p99_ms,
                  times.median_ms * 1e6 / all, goal_ns, size, static_cast<double>(size) / all,
                  static_cast<double>(size) * 8.0 * 90.0 * 1e-6);
    };
    const auto report = [&](const char* stage, const bench::Times& times) {
      report_bytes(stage, times, bytes.size());
    };
    report("encode", bench::time_of(10, 200, [&] { (void)encode_frame(frame); }));
    report("decode", bench::time_of(10, 200, [&] { (void)decode_frame(bytes); }));

    // The same drivers as a stream: each frame relative to the previous one.
    const std::vector<DriverFrame> motion = motion_of(one.driver_kind, one.objects, one.drivers, 211);
    StreamBaselinePtr baseline;
    std::vector<std::vector<std::byte>> frames;
    const bench::Times encode = bench::time_of(10, 200, [&] {
      EncodedStreamFrame encoded = encode_stream_frame(motion[frames.size()], baseline);
      baseline = encoded.next;
      frames.push_back(std::move(encoded.bytes));
    });
    StreamReader reader;
    size_t next = 0, streamed = 0;
    const bench::Times decode = bench::time_of(10, 200, [&] { (void)reader.read(frames[next++]); });
    for (size_t i = 10; i < frames.size(); ++i) streamed += frames[i].size();
    const size_t mean = streamed / (frames.size() - 10);
    report_bytes("stream encode", encode, mean);
    report_bytes("stream decode", decode, mean);
  }
  return 0;
}
