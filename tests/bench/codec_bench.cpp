// SPDX-License-Identifier: Apache-2.0
// What a frame of real motion takes on the wire, and how far off it is, in every encoding. Prints CSV: `codec_bench >
// results/<machine>/codec.csv`; codec_chart.gnuplot draws it. Four elastic blocks of 28 cm (1e4 Pa, 10 x 10 x 10 cells each) are
// torn to and fro by springs whose targets jump about, up to 0.3 m twice a second, while 200 boxes of 4 cm fall onto a floor
// among them; 6 s at 90 Hz, the first not counted. Then all are let be until they sleep, or for 12 s. Errors of drivers are the
// largest of all frames. A million kernels ride in the blocks, skinned from the server's drivers and from those that were read,
// in every 45th frame; encodings of kernels are of these frames alone.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>

#include "bench/arguments.h"
#include "bench/dragged_blocks.h"
#include "bench/kernel_errors.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"
#include "wire/kernel_codec.h"

using namespace livegs;
using namespace livegs::bench;

namespace {

constexpr size_t kFirst = 90, kDragged = 540, kEvery = 45;
constexpr size_t kKernels = 1'000'000 / kBlocks;

struct Sent {
  std::vector<std::byte> bytes;
  DriverFrame read;
};
struct Encoding {
  std::string name;
  std::function<Sent(const DriverFrame&)> send;
};

struct Tally {
  std::vector<size_t> sizes;
  double metres = 0, degrees = 0;
  KernelErrors kernels;

  void add(const DriverFrame& sent, const DriverFrame& read) {
    for (size_t i = 0; i < sent.objects.size(); ++i) {
      const ObjectDrivers &a = sent.objects[i], &b = read.objects[i];
      for (size_t k = 0; k < a.positions_m.size(); ++k)
        metres = std::max(metres, static_cast<double>((a.positions_m[k] - b.positions_m[k]).norm()));
      for (size_t k = 0; k < a.poses.size(); ++k) {
        metres = std::max(metres, (a.poses[k].position_m - b.poses[k].position_m).norm());
        degrees = std::max(degrees, 180.0 / M_PI * a.poses[k].orientation.angularDistance(b.poses[k].orientation));
      }
    }
  }
};

void print(const std::string& encoding, const char* phase, Tally& tally) {
  std::sort(tally.sizes.begin(), tally.sizes.end());
  double sum = 0;
  for (const size_t size : tally.sizes) sum += static_cast<double>(size);
  const double mean = sum / static_cast<double>(tally.sizes.size());
  const Percentiles &mm = tally.kernels.position_mm, &deg = tally.kernels.rotation_deg;
  std::printf("\"%s\",%s,%zu,%zu,%zu,%.0f,%.2f,%.4f,%.4f", encoding.c_str(), phase, tally.sizes.size(),
              tally.sizes[tally.sizes.size() / 2], tally.sizes[tally.sizes.size() * 95 / 100], mean, mean * 8 * 90 * 1e-6,
              1e3 * tally.metres, tally.degrees);
  std::printf(",%.5f,%.5f,%.5f,%.5f,%.5f,%.3f\n", mm.percentile(0.99), mm.largest, deg.percentile(0.99), deg.percentile(0.999),
              deg.largest, 100 * deg.share_above(0.1));
  std::fflush(stdout);
}

Encoding self_contained(const std::string& name, DriverEncoding how) {
  return {name, [how](const DriverFrame& frame) {
            std::vector<std::byte> bytes = encode_frame(frame, how);
            auto read = decode_frame(bytes);
            return Sent{std::move(bytes), std::move(*read)};
          }};
}

Encoding stream(const std::string& name, const GridPrecision& precision, bool neighbours = true) {
  const auto baseline = std::make_shared<StreamBaselinePtr>();
  const auto reader = std::make_shared<StreamReader>();
  return {name, [=](const DriverFrame& frame) {
            StreamOptions options;
            options.precision = precision;
            options.tell_neighbours = neighbours;
            EncodedStreamFrame encoded = encode_stream_frame(frame, *baseline, options);
            *baseline = encoded.next;
            auto read = reader->read(encoded.bytes);
            if (!read) std::fprintf(stderr, "%s\n", read.error().message.c_str());
            return Sent{std::move(encoded.bytes), read ? std::move(*read) : DriverFrame{}};
          }};
}

std::vector<Encoding> encodings() {
  std::vector<Encoding> all = {self_contained("drivers raw", DriverEncoding::Raw),
                               self_contained("drivers self-contained", DriverEncoding::Quantised)};
  for (const int finest : {-12, -13, -14, -15, -16, -17, -18}) {
    char name[64];
    std::snprintf(name, sizeof name, "drivers in steps of %.1f um", 1e6 * kStepPart * std::exp2(finest));
    all.push_back(stream(name, {2 - std::min(finest, -14), finest, -18}));
  }
  all.push_back(stream("drivers without neighbours in steps of 57.2 um", {}, false));
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What frames of real motion take on the wire, and how far off they are; CSV on standard output", "codec_bench");
  read_arguments(app, argc, argv);
  World world = dragged_blocks();
  std::vector<BoundKernels> bound;
  for (uint32_t block = 1; block <= kBlocks; ++block) bound.emplace_back(world.rest_body(block), kKernels, block);
  std::printf(
      "encoding,phase,frames,bytes_p50,bytes_p95,bytes_mean,mbit_s_at_90_hz,driver_largest_mm,driver_largest_deg,"
      "kernel_p99_mm,kernel_largest_mm,kernel_p99_deg,kernel_p999_deg,kernel_largest_deg,kernels_over_0.1_deg_percent\n");

  const std::vector<Encoding> all = encodings();
  std::vector<Tally> tallies(all.size());
  Tally exact, quantised;
  DriverFrame frame;
  for (size_t i = 0; i < kDragged; ++i) {
    drag(world, world.tick());
    world.step();
    frame = world.drivers();
    KernelFrame kernels;
    const bool looked_at = i >= kFirst && i % kEvery == 0;
    for (size_t k = 0; looked_at && k < kBlocks; ++k) kernels.objects.push_back({frame.objects[k].object_id, 0, bound[k].pose(frame.objects[k])});
    for (size_t e = 0; e < all.size(); ++e) {
      const Sent sent = all[e].send(frame);
      if (i < kFirst) continue;
      tallies[e].sizes.push_back(sent.bytes.size());
      tallies[e].add(frame, sent.read);
      for (size_t k = 0; k < kernels.objects.size(); ++k)
        add_errors(kernels.objects[k].kernels, bound[k].pose(sent.read.objects[k]), tallies[e].kernels);
    }
    if (!looked_at) continue;
    for (const auto& [encoding, tally] : {std::pair{KernelEncoding::Exact, &exact}, {KernelEncoding::Quantised, &quantised}}) {
      const std::vector<std::byte> bytes = encode_kernels(kernels, encoding);
      tally->sizes.push_back(bytes.size());
      const auto read = decode_kernels(bytes);
      for (size_t k = 0; k < kernels.objects.size(); ++k)
        add_errors(kernels.objects[k].kernels, read->objects[k].kernels, tally->kernels);
    }
  }
  print("kernels exact", "dragged", exact);
  print("kernels quantised", "dragged", quantised);
  for (size_t e = 0; e < all.size(); ++e) print(all[e].name, "dragged", tallies[e]);

  for (uint32_t i = 0; i < kBlocks; ++i) world.clear_spring(i);
  const auto all_asleep = [&] {
    return std::all_of(frame.objects.begin(), frame.objects.end(), [](const ObjectDrivers& o) { return o.asleep; });
  };
  const Encoding left_alone = stream("drivers in steps of 57.2 um", {});
  const auto step = [&] {
    world.step();
    frame = world.drivers();
    return left_alone.send(frame);
  };
  for (int i = 0; i < 90 * 12 && !all_asleep(); ++i) step();
  Tally tally;
  for (int i = 0; i < 90; ++i) {
    const Sent sent = step();
    tally.sizes.push_back(sent.bytes.size());
    tally.add(frame, sent.read);
  }
  print(left_alone.name, all_asleep() ? "asleep" : "left alone", tally);
  return 0;
}
