// SPDX-License-Identifier: Apache-2.0
// core_trace OUTPUT [LATTICE_KERNELS [FRAMES]]: runs the client core natively on a made scene, checks it
// against skin_kernels and the depth keys of the native renderer, and writes its input and results for
// core_test.mjs, which compares the WebAssembly module with them to the bit. Prints the least times in ms as
// JSON.
//
// The scene: a static environment, an elastic block with haze, and a rigid box that breaks in three halfway.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/serial_here.h"
#include "gaussian/progressive_asset.h"
#include "gaussian/stored_blocks.h"
#include "skin/drivers/node_neighbours.h"
#include "skin/skin_kernels.h"
#include "splat/passes/key_order.h"
#include "splat/project/raster_options.h"
#include "web/core/asset_binder.h"
#include "web/core/live_scene.h"
#include "wire/frame_stream.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "core_trace: %s\n", what.c_str());
  std::exit(1);
}
void require(bool condition, const char* what) {
  if (!condition) fail(what);
}

GaussianAsset made_asset(size_t kernels, int degree, const Eigen::Vector3f& size, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto vector = [&] { return Eigen::Vector3f(unit(random), unit(random), unit(random)); };
  GaussianAsset asset;
  asset.sh_degree = degree;
  asset.resize(kernels);
  for (size_t k = 0; k < kernels; ++k) {
    asset.positions[k] =
        (0.52f * vector().array() * size.array()).matrix();  // 4 % of the size outside, on both sides
    asset.log_scales[k] = Eigen::Vector3f::Constant(-5) + vector();
    asset.rotations[k] =
        Eigen::Quaternionf(unit(random), unit(random), unit(random), unit(random)).normalized();
    asset.opacity_logits[k] = 4 * unit(random);
    asset.sh_dc[k] = vector();
  }
  for (Eigen::Vector3f& one : asset.sh_rest) one = 0.2f * vector();
  return asset;
}

// A block of n^3 cells around the origin.
RestBody made_lattice(int n, double width_m) {
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.object_from_asset.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()));
  rest.cell_width_m = width_m;
  rest.object_from_lattice.position_m = Eigen::Vector3d::Constant(-0.5 * n * width_m);
  const auto node = [n](int x, int y, int z) {
    return static_cast<uint32_t>((z * (n + 1) + y) * (n + 1) + x);
  };
  for (int z = 0; z <= n; ++z)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) rest.node_coordinates.push_back({x, y, z});
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        auto& cell = rest.cells.emplace_back();
        for (int c = 0; c < 8; ++c)
          cell[static_cast<size_t>(c)] = node(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
      }
  return rest;
}

Pose pose_at(double t, double x) {
  Pose pose;
  pose.orientation = Eigen::AngleAxisd(1.3 * t + x, Eigen::Vector3d(0.2, 1, x).normalized());
  pose.position_m = {x + 0.3 * std::sin(2 * t), 0.2 * t, 0.1 * std::cos(3 * t + x)};
  return pose;
}

class Trace {
 public:
  explicit Trace(const char* path) : out_(path, std::ios::binary) {}
  template <class... Parts>
  void write(uint32_t kind, const Parts&... parts) {
    std::vector<std::byte> bytes;
    (append_part(bytes, parts), ...);
    const uint32_t head[2] = {kind, static_cast<uint32_t>(bytes.size())};
    out_.write(reinterpret_cast<const char*>(head), sizeof head);
    out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize((4 - bytes.size() % 4) % 4);
    out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    require(out_.good(), "the trace cannot be written");
  }

 private:
  template <class Part>
  static void append_part(std::vector<std::byte>& bytes, const Part& part) {
    const auto view = [&] {
      if constexpr (std::is_arithmetic_v<Part>)
        return std::as_bytes(std::span(&part, 1));
      else
        return std::as_bytes(std::span(part));
    }();
    bytes.insert(bytes.end(), view.begin(), view.end());
  }
  std::ofstream out_;
};

enum Kind : uint32_t { kAsset = 1, kDescribe, kFrame, kView, kPlay, kDrivers, kKernels, kOrder };

// The quickest frame: on a shared machine, means tell more of the others.
struct Times {
  double decode_ms = 1e9, play_ms = 1e9, keys_ms = 1e9, sort_ms = 1e9;
};
template <class Step>
auto timed(double& least_ms, const Step& step) {
  const auto begun = std::chrono::steady_clock::now();
  auto result = step();
  const double passed_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
  least_ms = std::min(least_ms, passed_ms);
  return result;
}

// The kernels of a drawn object against skin_kernels, and its keys against those of its posed rows. Rigid
// positions are those of the pass skin_rigid, which sums in another order than skin_kernels.
void check(const LiveScene::Object& object, const GaussianAsset& asset, const RestBody& rest,
           const OrderView& view) {
  const auto bindings = bind_kernels(asset, rest);
  require(bindings.has_value(), "the whole asset cannot be bound");
  PosedKernels posed;
  skin_kernels(asset, rest, *bindings, *object.posed_by, posed);
  require(object.size() == asset.size(), "kernels are missing");
  for (size_t k = 0; k < asset.size(); ++k) {
    const Eigen::Vector3f& x = posed.positions_m[k];
    const Eigen::Vector3f found(object.positions.x_m[k], object.positions.y_m[k], object.positions.z_m[k]);
    const Symmetric3f& s = posed.covariances_m2[k];
    const bool same =
        rest.kind == DriverKind::Rigid ? (x - found).norm() <= 1e-6f * (1 + x.norm()) : x == found;
    require(same, "a position differs from skin_kernels");
    if (rest.kind == DriverKind::Rigid) continue;
    const PosedKernelRow row{x[0], x[1], x[2], s[0], s[1], s[2], s[3], s[4], s[5], 0, 0, 0, 1};
    require(object.keys[k] == ordered_key(order_depth(view, row, 0)), "a key differs");
  }
}

int run(const char* path, size_t lattice_kernels, int frames) {
  set_serial_here(true);
  Trace trace(path);
  AssetBinder binder;
  LiveScene scene;
  std::map<uint32_t, AssetBinder::Bound> packed;  // by description
  const GaussianAsset assets[4] = {made_asset(lattice_kernels / 4 + 7, 1, {6, 3, 6}, 1),
                                   made_asset(lattice_kernels, 3, {0.8f, 0.8f, 0.8f}, 2),
                                   made_asset(lattice_kernels / 8 + 9, 0, {0.3f, 0.3f, 0.3f}, 3),
                                   made_asset(lattice_kernels / 8 + 11, 2, {0.3f, 0.3f, 0.3f}, 4)};
  RestBody rests[4];
  rests[0].bodies.resize(1);
  rests[1] = made_lattice(14, 0.8 / 14);
  rests[2].bodies.resize(1);
  rests[3].revision = 1;
  const auto count = static_cast<uint32_t>(assets[3].size());
  for (int b = 0; b < 3; ++b) rests[3].bodies.emplace_back().position_m.x() = 0.1 * b - 0.1;
  rests[3].kernel_runs = {{0, count / 2}, {2, 17}, {1, count - count / 2 - 17}};

  const auto bind_arrived = [&] {
    for (Result<bool> any = binder.bind_next();; any = binder.bind_next()) {
      require(any.has_value(), "an object cannot be bound");
      if (!*any) return;
      const AssetBinder::Bound& bound = packed[binder.bound().description] = binder.bound();
      scene.begin_bound(bound.description, bound.reserved);
      scene.take_rows(bound.rest);
      const auto used = scene.end_bound(bound.node_terms, bound.node_terms_begin);
      require(used.has_value() && *used, "bound kernels are not used");
    }
  };
  const auto give_asset = [&](uint32_t number) {
    const auto stored = store_blocks(encode_progressive(assets[number]));
    require(stored.has_value(), "an asset cannot be stored");
    trace.write(kAsset, number, *stored);
    require(binder.take_asset(number, *stored).has_value() && binder.finish_asset(number),
            "an asset cannot be read");
    bind_arrived();
  };
  uint32_t description = 0;
  const auto describe = [&](uint32_t id, uint32_t asset, bool added, bool environment) {
    const auto rest = encode_rest_body(rests[asset]);
    trace.write(kDescribe, ++description, id, uint32_t{added}, uint32_t{environment}, uint32_t{0}, asset,
                rest);
    const auto described = scene.describe(description, id, added, environment, false, rest);
    require(described.has_value() && *described && binder.describe(description, asset, rest).has_value(),
            "an object cannot be described");
    bind_arrived();
  };
  for (uint32_t i = 0; i < 3; ++i) {
    describe(i + 1, i, true, i == 0);
    give_asset(i);
  }
  const NodeNeighboursPtr neighbours = find_node_neighbours(rests[1].node_coordinates);

  scene.begin_stream();
  StreamBaselinePtr baseline;
  Times times;
  OrderView view{};
  const int64_t period_ns = 1'000'000'000 / 60;
  size_t orders = 0;
  for (int f = 0; f < frames; ++f) {
    const double t = f / 60.0;
    if (f == frames / 3) {  // announced, and its asset arrives, before the break
      describe(3, 3, false, false);
      give_asset(3);
    }
    DriverFrame frame{static_cast<uint64_t>(f + 1), (f + 1) * period_ns, {}};
    for (uint32_t id = 1; id <= 3; ++id) {
      ObjectDrivers& drivers = frame.objects.emplace_back();
      drivers.object_id = id;
      if (id == 1) drivers.poses = {Pose{}};
      if (id == 2) {
        drivers.kind = DriverKind::Lattice;
        drivers.neighbours = neighbours;
        for (const Eigen::Vector3i& at : rests[1].node_coordinates) {
          const Eigen::Vector3d x =
              rests[1].object_from_lattice * (rests[1].cell_width_m * at.cast<double>());
          drivers.positions_m.push_back(
              (x + 0.1 * std::sin(5 * t) *
                       Eigen::Vector3d(std::sin(4 * x.y()), std::cos(6 * x.x()), x.z() * x.y()))
                  .cast<float>());
        }
      }
      if (id == 3) {
        const bool broken = f >= frames / 2;
        drivers.revision = broken ? 1 : 0;
        for (int b = 0; b < (broken ? 3 : 1); ++b) drivers.poses.push_back(pose_at(t, 0.1 * b));
      }
    }
    const EncodedStreamFrame encoded = encode_stream_frame(frame, baseline);
    baseline = encoded.next;
    const double received_ns = 5e9 + static_cast<double>((f + 1) * period_ns), now_ns = received_ns + 1e6;
    trace.write(kFrame, received_ns, static_cast<double>(f + 1), encoded.bytes);
    require(
        timed(times.decode_ms,
              [&] { return scene.take_frame(encoded.bytes, static_cast<int64_t>(received_ns)).has_value(); }),
        "a frame cannot be read");

    view = {{static_cast<float>(2 * std::sin(t)), 0.4f, static_cast<float>(2 * std::cos(t))},
            {static_cast<float>(-std::sin(t)), 0, static_cast<float>(-std::cos(t))},
            f % 2 == 1};
    trace.write(kView, view.origin_m.x, view.origin_m.y, view.origin_m.z, view.axis.x, view.axis.y,
                view.axis.z, uint32_t{view.by_distance});
    scene.set_view(view);
    const bool changed = timed(times.play_ms, [&] { return scene.play(static_cast<int64_t>(now_ns)); });
    trace.write(kPlay, now_ns, uint32_t{changed}, scene.drawn());
    for (const uint32_t id : scene.drawn()) {
      const LiveScene::Object& object = *scene.find(id);
      if (!object.moved && !object.fresh) continue;
      const bool lattice = object.rest.kind == DriverKind::Lattice;
      trace.write(kDrivers, id,
                  lattice ? std::as_bytes(std::span(object.rows.nodes))
                          : std::as_bytes(std::span(object.rows.bodies)));
      if (!object.fresh) continue;
      const AssetBinder::Bound& bound = packed.at(object.description);
      const auto size = static_cast<uint32_t>(bound.rest.size());
      trace.write(kKernels, id, object.base, size, static_cast<uint32_t>(object.rest.cells.size()),
                  static_cast<uint32_t>(bound.bands.size()), bound.rest, object.rest.cells, bound.looks,
                  bound.bands);
      scene.kernels_sent(id);
    }
    timed(times.keys_ms, [&] { return scene.update_keys(), 0; });
    const auto order = timed(times.sort_ms, [&] { return scene.sort(); });
    trace.write(kOrder, order);
    orders += order.size();
    if (f % 20 != 7) continue;
    for (const uint32_t id : scene.drawn()) {
      const LiveScene::Object& object = *scene.find(id);
      const uint32_t which = id < 3 ? id - 1 : 2 + object.posed_by->revision;
      check(object, assets[which], rests[which], view);
    }
    std::vector<uint32_t> expected(order.begin(), order.end());  // sorted again, by another algorithm
    std::vector<uint64_t> keyed;
    for (const uint32_t id : scene.drawn()) {
      const LiveScene::Object& object = *scene.find(id);
      for (uint32_t k = 0; k < object.size(); ++k)
        keyed.push_back(uint64_t{object.keys[k]} << 32 | (object.base + k));
    }
    std::stable_sort(keyed.begin(), keyed.end(), [](uint64_t a, uint64_t b) { return a >> 32 < b >> 32; });
    for (size_t i = 0; i < keyed.size(); ++i)
      require(static_cast<uint32_t>(keyed[i]) == order[i], "the order differs");
  }
  std::printf(
      "{\"kernels\": %.0f, \"decode_ms\": %.4f, \"play_ms\": %.4f, \"keys_ms\": %.4f, \"sort_ms\": %.4f}\n",
      static_cast<double>(orders) / frames, times.decode_ms, times.play_ms, times.keys_ms, times.sort_ms);
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) {
  if (argc < 2) livegs::fail("usage: core_trace OUTPUT [LATTICE_KERNELS [FRAMES]]");
  return livegs::run(argv[1], argc > 2 ? std::stoul(argv[2]) : 20'000, argc > 3 ? std::stoi(argv[3]) : 60);
}
