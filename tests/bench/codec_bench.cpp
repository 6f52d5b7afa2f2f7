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

#include "bench/dragged_blocks.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"

using namespace livegs;
using namespace livegs::bench;

namespace {

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
  World world = dragged_blocks();
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
