// SPDX-License-Identifier: Apache-2.0
// What a frame of real motion takes on the wire, and how far off it is. Prints CSV: `codec_bench >
// results/<machine>/codec.csv`. Four elastic blocks of 28 cm (1e4 Pa, 10 x 10 x 10 cells each) are torn to
// and fro by springs whose targets jump about, up to 0.3 m twice a second, while 200 boxes of 4 cm fall onto
// a floor among them; 6 s at 90 Hz. Then all are let be until they sleep. Errors are those of drivers against
// the server's own, largest of all frames; an elastic kernel's is never more than its nodes'.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "geometry/mass_properties.h"
#include "geometry/shape_mesh.h"
#include "physics/world.h"
#include "server/physics/elastic_bodies.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"

using namespace livegs;
using namespace livegs::test;

namespace {

constexpr int kBlocks = 4, kBoxes = 200;
constexpr double kSide_m = 0.28;

World made_world() {
  WorldSettings settings;
  World world(settings);
  Collider floor;
  floor.shape = PlaneShape{};
  floor.friction = 0.6;
  world.add_collider(floor);
  for (uint32_t i = 0; i < kBlocks; ++i) {
    ElasticBodyDescription block =
        describe(particle_grid(Vector3d::Constant(kSide_m), kSide_m / 10), 1e4, 0.3, kSide_m / 10);
    block.object_id = i + 1;
    block.material.loss_factor = 0.1;
    block.world_from_object.position_m = {0.8 * (i % 2), 0.5, 0.8 * (i / 2)};
    if (auto added = world.add_elastic(block); !added)
      std::fprintf(stderr, "%s\n", added.error().message.c_str());
  }
  const TriangleMesh box = box_mesh({0.04, 0.04, 0.04});
  for (uint32_t i = 0; i < kBoxes; ++i) {
    RigidBodyDescription body;
    body.object_id = 100 + i;
    body.mesh = box;
    body.properties = solid_mass_properties(box);
    body.material.mass_kg = 0.05;
    body.world_from_object.position_m = {-0.5 + 0.09 * (i % 10), 1.0 + 0.09 * (i / 50),
                                         -0.5 + 0.09 * (i / 10 % 5)};
    body.angular_velocity_rad_s = {3.0, 0.1 * i, 1.0};
    if (auto added = world.add_rigid(body); !added)
      std::fprintf(stderr, "%s\n", added.error().message.c_str());
  }
  return world;
}

void drag(World& world, uint64_t tick) {
  for (uint32_t i = 0; i < kBlocks; ++i) {
    const uint64_t jump = tick / 45 + i;
    const Vector3d away(0.3 * std::sin(2.1 * static_cast<double>(jump)),
                        0.3 + 0.2 * std::sin(3.7 * static_cast<double>(jump)),
                        0.3 * std::cos(1.3 * static_cast<double>(jump)));
    world.set_spring(i, i + 1,
                     {{0.4 * kSide_m, 0.4 * kSide_m, 0.0},
                      Vector3d(0.8 * (i % 2), 0.3, 0.8 * (i / 2)) + away,
                      2000.0,
                      400.0});
  }
}

struct Error {
  double metres = 0, degrees = 0;
  void add(const DriverFrame& sent, const DriverFrame& read) {
    for (size_t i = 0; i < sent.objects.size(); ++i) {
      const ObjectDrivers &a = sent.objects[i], &b = read.objects[i];
      for (size_t k = 0; k < a.positions_m.size(); ++k) {
        metres = std::max(metres, static_cast<double>((a.positions_m[k] - b.positions_m[k]).norm()));
      }
      for (size_t k = 0; k < a.poses.size(); ++k) {
        metres = std::max(metres, (a.poses[k].position_m - b.poses[k].position_m).norm());
        degrees =
            std::max(degrees, 180.0 / M_PI * a.poses[k].orientation.angularDistance(b.poses[k].orientation));
      }
    }
  }
};

struct Sent {
  std::vector<std::byte> bytes;
  DriverFrame read;
};

void report(const char* encoding, const char* phase, const std::vector<DriverFrame>& motion, size_t begin,
            size_t end, const std::function<Sent(const DriverFrame&)>& send) {
  std::vector<size_t> sizes;
  Error error;
  for (size_t i = 0; i < end; ++i) {
    const Sent sent = send(motion[i]);
    if (i < begin) continue;
    sizes.push_back(sent.bytes.size());
    error.add(motion[i], sent.read);
  }
  std::sort(sizes.begin(), sizes.end());
  double sum = 0;
  for (const size_t size : sizes) sum += static_cast<double>(size);
  const double mean = sum / static_cast<double>(sizes.size());
  std::printf("%s,%s,%zu,%zu,%zu,%.0f,%.2f,%.4f,%.4f\n", encoding, phase, sizes.size(),
              sizes[sizes.size() / 2], sizes[sizes.size() * 95 / 100], mean, mean * 8 * 90 * 1e-6,
              1e3 * error.metres, error.degrees);
  std::fflush(stdout);
}

}  // namespace

int main() {
  World world = made_world();
  std::vector<DriverFrame> motion;
  size_t moving = 0;
  for (int i = 0; i < 540; ++i) {
    drag(world, world.tick());
    world.step();
    motion.push_back(world.drivers());
  }
  moving = motion.size();
  for (uint32_t i = 0; i < kBlocks; ++i) world.clear_spring(i);
  const auto all_asleep = [&] {
    return std::all_of(motion.back().objects.begin(), motion.back().objects.end(),
                       [](const ObjectDrivers& o) { return o.asleep; });
  };
  for (int i = 0; i < 90 * 12 && !all_asleep(); ++i) {
    world.step();
    motion.push_back(world.drivers());
  }
  const size_t settled = motion.size();
  std::fprintf(stderr, "%zu frames, %s\n", settled, all_asleep() ? "all asleep" : "some still awake");
  for (int i = 0; i < 90; ++i) {
    world.step();
    motion.push_back(world.drivers());
  }
  std::printf(
      "encoding,phase,frames,bytes_p50,bytes_p95,bytes_mean,mbit_s_at_90_hz,largest_error_mm,largest_error_"
      "deg\n");
  const auto self_contained = [](const DriverFrame& frame) {
    std::vector<std::byte> bytes = encode_frame(frame);
    auto read = decode_frame(bytes);
    return Sent{std::move(bytes), std::move(*read)};
  };
  report("self-contained", "dragged", motion, 90, moving, self_contained);
  report("self-contained", "left alone", motion, settled, motion.size(), self_contained);
  for (const int finest : {-13, -14, -15, -16, -17}) {
    StreamBaselinePtr baseline;
    StreamReader reader;
    StreamOptions options;
    options.precision.finest_exponent = finest;
    options.precision.position_bits = finest == -17 ? 18 : 16;
    const auto stream = [&](const DriverFrame& frame) {
      EncodedStreamFrame encoded = encode_stream_frame(frame, baseline, options);
      baseline = encoded.next;
      auto read = reader.read(encoded.bytes);
      return Sent{std::move(encoded.bytes), std::move(*read)};
    };
    const std::string name = "stream, steps of 2^" + std::to_string(finest) + " m";
    const std::string quoted = "\"" + name + "\"";
    report(quoted.c_str(), "dragged", motion, 90, moving, stream);
    baseline = nullptr;
    report(quoted.c_str(), "left alone", motion, settled, motion.size(), stream);
  }
}
