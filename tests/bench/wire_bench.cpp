// SPDX-License-Identifier: Apache-2.0
// Time and bytes to encode and decode driver frames. Prints CSV: `wire_bench > results/<machine>/wire.csv`.
// Objects move as a twisted ball does. Ten runs warm up, 200 count. One thread: the codec uses no other.
#include <cstdio>

#include "bench/time_of.h"
#include "common/skin/rest_bodies.h"
#include "wire/frame_codec.h"

using namespace livegs;
using namespace livegs::testing;

namespace {

DriverFrame frame_of(DriverKind kind, size_t objects, size_t drivers, uint64_t seed) {
  std::mt19937_64 random(seed);
  DriverFrame frame;
  for (size_t i = 0; i < objects; ++i) {
    ObjectDrivers object;
    object.object_id = static_cast<uint32_t>(i + 1);
    object.kind = kind;
    for (size_t d = 0; d < drivers; ++d) {
      const Eigen::Vector3d at = uniform3(random, -0.5, 0.5);
      if (kind == DriverKind::Rigid) {
        object.poses.push_back({at, random_rotation(random)});
      } else {
        object.positions_m.push_back(at.cast<float>());
        if (kind == DriverKind::Particles) object.rotations.push_back(random_rotation(random).cast<float>());
      }
    }
    frame.objects.push_back(object);
  }
  return frame;
}

}  // namespace

int main() {
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
      "kind,objects,drivers,stage,median_ms,p99_ms,ns_per_driver,bytes,bytes_per_driver,mbit_s_at_90_hz\n");
  for (const Case& one : cases) {
    const DriverFrame frame = frame_of(one.driver_kind, one.objects, one.drivers, 1);
    const std::vector<std::byte> bytes = encode_frame(frame);
    const double all = static_cast<double>(one.objects * one.drivers);
    const auto report = [&](const char* stage, const bench::Times& times) {
      std::printf("%s,%zu,%zu,%s,%.4f,%.4f,%.1f,%zu,%.2f,%.2f\n", one.kind, one.objects,
                  one.objects * one.drivers, stage, times.median_ms, times.p99_ms,
                  times.median_ms * 1e6 / all, bytes.size(), static_cast<double>(bytes.size()) / all,
                  static_cast<double>(bytes.size()) * 8.0 * 90.0 * 1e-6);
    };
    report("encode", bench::time_of(10, 200, [&] { (void)encode_frame(frame); }));
    report("decode", bench::time_of(10, 200, [&] { (void)decode_frame(bytes); }));
  }
  return 0;
}
