// SPDX-License-Identifier: Apache-2.0
// Bytes of frames of real motion and errors of the received state, for every encoding. Prints CSV:
// `codec_bench > results/<machine>/codec.csv`; codec_chart.gnuplot draws it.
// Four elastic blocks of 28 cm (1e4 Pa, 10 x 10 x 10 cells each) are pulled by springs whose targets jump by
// up to 0.3 m twice a second, while 200 boxes of 4 cm fall onto a floor among them. 6 s at 90 Hz; the first
// second is not counted. Then all forces stop until everything sleeps, at most 12 s.
// Errors of drivers are the maximum over all frames. One million kernels are bound to the blocks and skinned
// from the server's and from the decoded drivers in every 45th frame; kernel encodings use these frames only.
// One row has 200 fragments of broken boxes in place of the boxes; three rows have blocks with smaller cells.
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "bench/support/arguments.h"
#include "bench/support/dragged_blocks.h"
#include "bench/support/kernel_errors.h"
#include "wire/driver_grid.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"
#include "wire/grid_coder.h"
#include "wire/kernel_codec.h"

using namespace livegs;
using namespace livegs::bench;

namespace {

constexpr size_t kFirst = 90, kDragged = 540, kEvery = 45;
constexpr size_t kKernels = 1'000'000 / kBlocks;

// Bounds during motion: bytes p95, Mbit/s, and position and rotation errors of the worst kernel. Asleep,
// frames contain only tick and time.
constexpr const char *kGoals = "12000,8,0.05,0.1", *kGoalsAsleep = "0,0,,", *kGoalsOfErrors = ",,0.05,0.1";

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
        degrees =
            std::max(degrees, 180.0 / M_PI * a.poses[k].orientation.angularDistance(b.poses[k].orientation));
      }
    }
  }
};

void print(const std::string& encoding, const char* phase, Tally& tally, const char* goals) {
  std::sort(tally.sizes.begin(), tally.sizes.end());
  double sum = 0;
  for (const size_t size : tally.sizes) sum += static_cast<double>(size);
  const double mean = sum / static_cast<double>(tally.sizes.size());
  const Percentiles &mm = tally.kernels.position_mm, &deg = tally.kernels.rotation_deg;
  std::printf("\"%s\",%s,%zu,%zu,%zu,%.0f,%.2f,%.4f,%.4f", encoding.c_str(), phase, tally.sizes.size(),
              tally.sizes[tally.sizes.size() / 2], tally.sizes[tally.sizes.size() * 95 / 100], mean,
              mean * 8 * 90 * 1e-6, 1e3 * tally.metres, tally.degrees);
  std::printf(",%.5f,%.5f,%.5f,%.5f,%.5f,%.3f,%s\n", mm.percentile(0.99), mm.largest, deg.percentile(0.99),
              deg.percentile(0.999), deg.largest, 100 * deg.share_above(0.1), goals);
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
            options.send_neighbours = neighbours;
            EncodedStreamFrame encoded = encode_stream_frame(frame, *baseline, options);
            *baseline = encoded.next;
            auto read = reader->read(encoded.bytes);
            if (!read) std::fprintf(stderr, "%s\n", read.error().message.c_str());
            return Sent{std::move(encoded.bytes), read ? std::move(*read) : DriverFrame{}};
          }};
}

// Reference for Rice codes: the same integers with the same prediction from previous frames, nodes in Morton
// order, each channel of all objects as byte planes (low bytes first, zero planes omitted), compressed with
// zstd. Object ids and prediction modes are not included and would add to it.
class BytePlanes {
 public:
  explicit BytePlanes(int level) : level_(level) {}

  Sent send(const DriverFrame& frame) {
    std::array<std::vector<uint32_t>, kMaxGridChannels> left;
    DriverFrame read{frame.tick, frame.simulated_ns, {}};
    for (const ObjectDrivers& object : frame.objects) {
      Past& past = past_[object.object_id];
      DriverGrid grid = to_grid(object, past.last ? &*past.last : nullptr, {});
      read.objects.push_back(from_grid(grid));
      if (past.order.empty()) past.order = morton_order(grid);
      if (past.last && grid.values == past.last->values) continue;
      add(grid, past, left);
      past.earliest = std::exchange(past.earlier, std::exchange(past.last, std::move(grid)));
    }
    return {packed(left), std::move(read)};
  }

 private:
  struct Past {
    std::optional<DriverGrid> last, earlier, earliest;
    std::vector<uint32_t> order;
  };

  static std::vector<uint32_t> morton_order(const DriverGrid& grid) {
    const auto spread = [](uint64_t value) {
      uint64_t bits = 0;
      for (int bit = 0; bit < 21; ++bit) bits |= (value >> bit & 1) << 3 * bit;
      return bits;
    };
    std::vector<std::pair<uint64_t, uint32_t>> codes;
    for (uint32_t i = 0; i < grid.count; ++i) {
      uint64_t code = 0;
      for (size_t axis = 0; axis < 3; ++axis)
        code |= spread(static_cast<uint32_t>(grid.values[axis * grid.count + i] + (1 << 19))) << axis;
      codes.emplace_back(code, i);
    }
    std::sort(codes.begin(), codes.end());
    std::vector<uint32_t> order;
    for (const auto& [code, index] : codes) order.push_back(index);
    return order;
  }

  static void add(const DriverGrid& grid, const Past& past,
                  std::array<std::vector<uint32_t>, kMaxGridChannels>& left) {
    const auto usable = [&](const std::optional<DriverGrid>& one) { return one && same_form(grid, *one); };
    const bool has_last = usable(past.last), has_linear = has_last && usable(past.earlier),
               has_curve = has_linear && usable(past.earliest);
    GridPast from;
    if (has_last) from.last = past.last->values.data();
    if (has_linear) from.earlier = past.earlier->values.data();
    if (has_curve) from.earliest = past.earliest->values.data();
    PredictionCosts costs{0, 0, 0};
    if (has_last) costs = prediction_costs(grid, from, has_linear, has_curve);
    const bool curve = has_curve && costs.curve <= std::min(costs.linear, costs.last),
               linear = has_linear && !curve && costs.linear < costs.last;
    if (curve && grid.kind == DriverKind::Lattice) fit_curve(grid, from);
    for (size_t channel = 0; channel < grid.channels(); ++channel) {
      for (const uint32_t node : past.order) {
        const size_t at = channel * grid.count + node;
        int64_t predicted = has_last ? from.last[at] : 0;
        if (linear) predicted += from.last[at] - from.earlier[at];
        if (curve) {
          const int64_t v = from.last[at] - from.earlier[at], a = v - (from.earlier[at] - from.earliest[at]);
          predicted += (from.weight_v * v + from.weight_a * a) >> 8;
        }
        const auto off = static_cast<int32_t>(grid.values[at] - predicted);
        left[channel].push_back(static_cast<uint32_t>(off) << 1 ^ static_cast<uint32_t>(off >> 31));
      }
    }
  }

  std::vector<std::byte> packed(const std::array<std::vector<uint32_t>, kMaxGridChannels>& left) const {
    std::vector<std::byte> planes;
    for (const std::vector<uint32_t>& channel : left) {
      for (int byte = 0; byte < 4; ++byte) {
        const auto of = [&](uint32_t value) { return static_cast<std::byte>(value >> 8 * byte); };
        const bool any = std::any_of(channel.begin(), channel.end(),
                                     [&](uint32_t value) { return of(value) != std::byte{0}; });
        planes.push_back(static_cast<std::byte>(any));
        for (size_t i = 0; any && i < channel.size(); ++i) planes.push_back(of(channel[i]));
      }
    }
    std::vector<std::byte> bytes(ZSTD_compressBound(planes.size()));
    bytes.resize(ZSTD_compress(bytes.data(), bytes.size(), planes.data(), planes.size(), level_));
    return bytes;
  }

  const int level_;
  std::map<uint32_t, Past> past_;
};

Encoding byte_planes(int level) {
  const auto planes = std::make_shared<BytePlanes>(level);
  return {"byte planes and zstd -" + std::to_string(level) + " in steps of 57.2 um",
          [planes](const DriverFrame& frame) { return planes->send(frame); }};
}

std::string steps_of(int finest) {
  char name[64];
  std::snprintf(name, sizeof name, "drivers in steps of %.1f um", 1e6 * kStepPart * std::exp2(finest));
  return name;
}

std::vector<Encoding> encodings() {
  std::vector<Encoding> all = {self_contained("drivers raw", DriverEncoding::Raw),
                               self_contained("drivers self-contained", DriverEncoding::Quantised)};
  for (const int finest : {-12, -13, -14, -15, -16, -17, -18})
    all.push_back(stream(steps_of(finest), {2 - std::min(finest, -14), finest, -18}));
  all.push_back(stream("drivers without neighbours in steps of 57.2 um", {}, false));
  for (const int level : {1, 3}) all.push_back(byte_planes(level));
  return all;
}

// The other dragged objects, in some encodings.
void print_dragged(World world, double side_m, const std::vector<Encoding>& all, const char* goals) {
  std::vector<BoundKernels> bound;
  for (uint32_t block = 1; block <= kBlocks; ++block)
    bound.emplace_back(world.rest_body(block), kKernels, block);
  std::vector<Tally> tallies(all.size());
  for (size_t i = 0; i < kDragged; ++i) {
    drag(world, world.tick(), side_m);
    world.step();
    const DriverFrame frame = world.drivers();
    const bool looked_at = i >= kFirst && i % kEvery == 0;
    std::vector<PosedKernels> kernels;
    for (size_t k = 0; looked_at && k < kBlocks; ++k) kernels.push_back(bound[k].pose(frame.objects[k]));
    for (size_t e = 0; e < all.size(); ++e) {
      const Sent sent = all[e].send(frame);
      if (i < kFirst) continue;
      tallies[e].sizes.push_back(sent.bytes.size());
      tallies[e].add(frame, sent.read);
      for (size_t k = 0; k < kernels.size(); ++k)
        add_errors(kernels[k], bound[k].pose(sent.read.objects[k]), tallies[e].kernels);
    }
  }
  for (size_t e = 0; e < all.size(); ++e) print(all[e].name, "dragged", tallies[e], goals);
}

void print_fragments() {
  World world = blocks_and_fragments();
  size_t poses = 0;
  for (const ObjectDrivers& one : world.drivers().objects) poses += one.poses.size();
  print_dragged(std::move(world), kSide_m,
                {stream(std::to_string(poses) + " fragments of 4 boxes: " + steps_of(-14), {})}, kGoals);
}

// The same blocks with a side of 10 cm and cells of 10 mm: rotation errors scale with the quantisation step
// over the cell width.
// width.
void print_small_cells() {
  constexpr double kSmallSide_m = 0.1;
  std::vector<Encoding> all;
  for (const int finest : {-14, -15, -16})
    all.push_back(stream("cells of 10 mm: " + steps_of(finest), {2 - std::min(finest, -14), finest, -18}));
  print_dragged(dragged_blocks(kSmallSide_m), kSmallSide_m, all, kGoalsOfErrors);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Bytes and errors of frames of real motion, by encoding; CSV on standard output",
               "codec_bench");
  read_arguments(app, argc, argv);
  World world = dragged_blocks();
  std::vector<BoundKernels> bound;
  for (uint32_t block = 1; block <= kBlocks; ++block)
    bound.emplace_back(world.rest_body(block), kKernels, block);
  std::printf(
      "encoding,phase,frames,bytes_p50,bytes_p95,bytes_mean,mbit_s_at_90_hz,driver_largest_mm,driver_largest_"
      "deg,"
      "kernel_p99_mm,kernel_largest_mm,kernel_p99_deg,kernel_p999_deg,kernel_largest_deg,kernels_over_0.1_"
      "deg_percent,"
      "goal_bytes_p95,goal_mbit_s,goal_kernel_largest_mm,goal_kernel_largest_deg\n");

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
    for (size_t k = 0; looked_at && k < kBlocks; ++k)
      kernels.objects.push_back({frame.objects[k].object_id, 0, bound[k].pose(frame.objects[k])});
    for (size_t e = 0; e < all.size(); ++e) {
      const Sent sent = all[e].send(frame);
      if (i < kFirst) continue;
      tallies[e].sizes.push_back(sent.bytes.size());
      tallies[e].add(frame, sent.read);
      for (size_t k = 0; k < kernels.objects.size(); ++k)
        add_errors(kernels.objects[k].kernels, bound[k].pose(sent.read.objects[k]), tallies[e].kernels);
    }
    if (!looked_at) continue;
    for (const auto& [encoding, tally] :
         {std::pair{KernelEncoding::Exact, &exact}, {KernelEncoding::Quantised, &quantised}}) {
      const std::vector<std::byte> bytes = encode_kernels(kernels, encoding);
      tally->sizes.push_back(bytes.size());
      const auto read = decode_kernels(bytes);
      for (size_t k = 0; k < kernels.objects.size(); ++k)
        add_errors(kernels.objects[k].kernels, read->objects[k].kernels, tally->kernels);
    }
  }
  print("kernels exact", "dragged", exact, kGoals);
  print("kernels quantised", "dragged", quantised, kGoals);
  for (size_t e = 0; e < all.size(); ++e) print(all[e].name, "dragged", tallies[e], kGoals);

  for (uint32_t i = 0; i < kBlocks; ++i) world.clear_spring(i);
  const auto all_asleep = [&] {
    return std::all_of(frame.objects.begin(), frame.objects.end(),
                       [](const ObjectDrivers& o) { return o.asleep; });
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
  print(left_alone.name, all_asleep() ? "asleep" : "left alone", tally, all_asleep() ? kGoalsAsleep : ",,,");
  print_fragments();
  print_small_cells();
  return 0;
}
