// SPDX-License-Identifier: GPL-3.0-or-later
#include "gpu_report/times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/skin/kernels/rest_bodies.h"
#include "common/splat/synthetic_kernels.h"
#include "compute/vulkan_backend.h"
#include "core/clock.h"
#include "core/percentile.h"
#include "skin/device_skin.h"
#include "splat/raster/frame_splats.h"

namespace livegs::gpu_report {
namespace {

// Frames of a row, if they do not take longer than the time limit. Warm-up frames come first: pipelines are
// compiled, and the clocks of a GPU rise. Most of a frame on a GPU is the read-back of its pixels.
struct FrameCounts {
  int warm_up, separate, whole, min;  // separate: a submission for each step
  double max_time_s;
};
constexpr FrameCounts kOnGpu{5, 7, 25, 7, 15}, kInSoftware{2, 7, 7, 3, 60};
constexpr uint32_t kBodies = 1000;
constexpr double kHalfEyeDistance_m = 0.032, kOrbit_m = 1.5, kView_rad = 0.8;

struct Samples {
  std::vector<double> ms;
  double median() const { return percentile(ms, 0.5); }
  Span span() const { return {median(), percentile(ms, 1.0)}; }
};

// The object as a client stores it: kernels bound to a twisted lattice, or to one of many rigid bodies.
struct Ridden {
  RestBody rest;
  KernelBindings bindings;
  ObjectDrivers drivers;
};

Result<Ridden> ride(const GaussianAsset& asset, RestBody rest) {
  Ridden ridden{std::move(rest), {}, {}};
  auto bindings = bind_kernels(asset, ridden.rest);
  if (!bindings) return bindings.error();
  ridden.bindings = *std::move(bindings);
  return Result<Ridden>(std::move(ridden));
}

Result<Ridden> ride_lattice(const GaussianAsset& asset) {
  const int across = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(asset.size())) /
                                                  4));  // 25 cells for one million kernels
  const auto in_shell = [across](int x, int y, int z) {
    const double middle = (Eigen::Vector3d(x, y, z) - Eigen::Vector3d::Constant(0.5 * (across - 1))).norm();
    return middle > 0.3 * across && middle < 0.55 * across;
  };
  RestBody rest = testing::lattice_body(across, across, across, 1.0 / across, in_shell);
  rest.object_from_lattice.position_m.setConstant(-0.5);
  auto ridden = ride(asset, rest);
  if (!ridden) return ridden;
  ridden->drivers = testing::moved_drivers(rest, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return Eigen::AngleAxisd(1.5 * x.y(), Eigen::Vector3d::UnitY()) * x;
  });
  return ridden;
}

Result<Ridden> ride_bodies(const GaussianAsset& asset) {
  RestBody rest;
  synthetic::Random random(2);
  for (uint32_t b = 0; b < kBodies; ++b) rest.bodies.push_back({random.in_ball(0.5), random.rotation()});
  auto ridden = ride(asset, rest);
  if (ridden) ridden->drivers.poses = rest.bodies;
  return ridden;
}

std::vector<Camera> eyes_at(double angle_rad, const TimesOptions& options, int count) {
  const Eigen::Vector3d from =
      kOrbit_m * Eigen::Vector3d(std::sin(angle_rad), 0.3, std::cos(angle_rad)).normalized();
  const Camera middle =
      look_at(from, {0, 0, 0}, Eigen::Vector3d::UnitY(), kView_rad, options.width, options.height);
  std::vector<Camera> eyes(static_cast<size_t>(count), middle);
  for (int e = 0; e < count && count == 2; ++e) {
    eyes[e].world_from_camera =
        middle.world_from_camera *
        Pose{{e == 0 ? -kHalfEyeDistance_m : kHalfEyeDistance_m, 0, 0}, Eigen::Quaterniond::Identity()};
  }
  return eyes;
}

class Bench {
 public:
  Bench(std::shared_ptr<VulkanDevice> device, const TimesOptions& options)
      : device_(std::move(device)),
        options_(options),
        counts_(device_->is_software() ? kInSoftware : kOnGpu) {}

  Result<void> make_object(size_t kernels) {
    // Kernels shrink with their number, so that the opacity of the shell stays the same.
    asset_ = synthetic::shell(kernels, 3, 0.9 / std::sqrt(static_cast<double>(kernels)), 1).asset;
    auto lattice = ride_lattice(asset_);
    if (!lattice) return lattice.error();
    auto bodies = ride_bodies(asset_);
    if (!bodies) return bodies.error();
    lattice_ = *std::move(lattice);
    bodies_ = *std::move(bodies);
    return {};
  }

  Result<TimesRow> measure(int eyes, DrawMethod method) {
    TimesRow row;
    row.kernels = asset_.size();
    row.eyes = eyes;
    row.width = options_.width;
    row.height = options_.height;
    row.method = method;
    row.blend_bits = method == DrawMethod::Quads ? 16 : 32;
    if (auto done = measure_pictures(row, true); !done) return done.error();
    if (auto done = measure_pictures(row, false); !done) return done.error();
    for (const auto& [ridden, span] :
         {std::pair{&lattice_, &row.skin}, std::pair{&bodies_, &row.skin_rigid}}) {
      auto samples = skin_times(*ridden);
      if (!samples) return samples.error();
      *span = samples->span();
    }
    auto memory = measure_memory(row);
    if (!memory) return memory.error();
    return row;
  }

 private:
  // Pictures with a submission for each step, or whole pictures.
  Result<void> measure_pictures(TimesRow& row, bool separate) {
    auto renderer = create_vulkan_renderer(
        device_, {.method = row.method, .precision = BlendPrecision::Half, .separate_times = separate});
    if (!renderer) return renderer.error();
    Samples upload, project, sort, draw, whole, device[5];
    std::vector<Image> images;
    const int max_frames = separate ? counts_.separate : counts_.whole;
    int frames = max_frames;
    for (int frame = -counts_.warm_up; frame < frames; ++frame) {
      const int64_t begun_ns = now_ns();
      // A new pose in each frame, as for a moving object; the asset is uploaded once.
      const RenderedObject rendered{
          {&asset_, nullptr, 0}, ++version_, 1, {&lattice_.rest, &lattice_.bindings, &lattice_.drivers}};
      RenderOptions options;
      options.order = DepthOrder::Distance;
      if (auto done = (*renderer)->draw(
              {&rendered, 1}, eyes_at(2.0 * M_PI * frame / frames, options_, row.eyes), options, images);
          !done)
        return done;
      if (const std::string notice = (*renderer)->notice(); !notice.empty())
        return Error{ErrorCode::TooLarge, notice};
      const double took_s = seconds_from_ns(now_ns() - begun_ns);
      if (frame == 1 - counts_.warm_up) {  // the first one also uploads the object and compiles pipelines
        frames =
            static_cast<int>(std::clamp(counts_.max_time_s / took_s, 1.0 * counts_.min, 1.0 * max_frames));
        if (frames < max_frames) frame = -1;  // no more warm-up
      }
      if (frame < 0) continue;
      const RenderTimes& times = (*renderer)->last_times();
      upload.ms.push_back(times.upload_ms);
      project.ms.push_back(times.project_ms);
      sort.ms.push_back(times.sort_ms);
      draw.ms.push_back(times.draw_ms);
      whole.ms.push_back(1e3 * took_s);
      const DeviceTimes by_device = times.device.value_or(DeviceTimes{});
      const double passes_ms[5] = {by_device.skin_ms, by_device.project_ms, by_device.sort_ms,
                                   by_device.draw_ms, by_device.resolve_ms};
      for (int pass = 0; pass < 5; ++pass) device[pass].ms.push_back(passes_ms[pass]);
    }
    if (separate) {
      row.upload = upload.span();
      row.project = project.span();
      row.sort = sort.span();
      row.draw = draw.span();
      return {};
    }
    row.frames = frames;
    row.frame = whole.span();
    row.device = {device[0].median(), device[1].median(), device[2].median(), device[3].median(),
                  device[4].median()};
    row.whole = (*renderer)->last_times();
    return {};
  }

  // The pass that a client runs, on a quarter of the kernels at a time, as in a frame.
  Result<Samples> skin_times(const Ridden& ridden) {
    const auto backend = create_vulkan_backend(device_);
    if (!backend) return backend.error();
    auto skin = DeviceSkin::create(**backend, ridden.rest, ridden.bindings);
    if (!skin) return skin.error();
    const uint32_t at_once = (skin->size() + 3) / 4;
    const auto posed = (*backend)->create_buffer(at_once * sizeof(PosedKernelRow));
    if (!posed) return posed.error();
    if (auto done = skin->move(ridden.rest, ridden.bindings, ridden.drivers); !done) return done.error();
    if (auto done = (*backend)->submit(); !done) return done.error();
    Samples samples;
    for (int frame = -counts_.warm_up; frame < counts_.separate; ++frame) {
      const int64_t begun_ns = now_ns();
      for (uint32_t first = 0, count = 0; first < skin->size(); first += count) {
        count = std::min({at_once, skin->size() - first,
                          DeviceSkin::kMaxPartKernels - first % DeviceSkin::kMaxPartKernels});
        if (auto done = skin->pose(first, count, *posed); !done) return done.error();
      }
      if (auto done = (*backend)->submit(); !done) return done.error();
      if (frame >= 0) samples.ms.push_back(milliseconds_from_ns(now_ns() - begun_ns));
    }
    return samples;
  }

  // Device memory of kernels, of their drivers, and of per-frame data; and the bytes that the passes move.
  Result<void> measure_memory(TimesRow& row) {
    const auto backend = create_vulkan_backend(device_);
    if (!backend) return backend.error();
    const auto kernels = DeviceKernels::create(**backend, asset_);
    if (!kernels) return kernels.error();
    auto skin = DeviceSkin::create(**backend, lattice_.rest, lattice_.bindings);
    if (!skin) return skin.error();
    if (auto done = skin->move(lattice_.rest, lattice_.bindings, lattice_.drivers); !done) return done;
    const FrameSplats::Object one{&*kernels, [&](uint32_t first, uint32_t count, BufferId posed) {
                                    return skin->pose(first, count, posed);
                                  }};
    const std::vector<Camera> cameras(static_cast<size_t>(row.eyes));
    FrameSplats frame(**backend);
    if (auto done = frame.project({&one, 1}, cameras, {}); !done) return done;
    if (auto done = (*backend)->submit(); !done) return done;
    row.memory_bytes_a_kernel =
        static_cast<double>(kernels->device_bytes() + skin->device_bytes() + frame.device_bytes()) /
        static_cast<double>(asset_.size());
    row.bytes = pass_bytes({.kernels = static_cast<double>(asset_.size()),
                            .cells = static_cast<double>(lattice_.rest.cells.size()),
                            .nodes = static_cast<double>(lattice_.drivers.positions_m.size()),
                            .eyes = 1.0 * row.eyes,
                            .pixels = 1.0 * row.width * row.height,
                            .sh_row_words = 1.0 * kernels->sh_row_words(),
                            .blend_bytes = row.blend_bits / 2.0});
    return {};
  }

  std::shared_ptr<VulkanDevice> device_;
  TimesOptions options_;
  FrameCounts counts_;
  GaussianAsset asset_;
  Ridden lattice_, bodies_;
  uint64_t version_ = 0;
};

}  // namespace

Result<void> measure_times(const std::shared_ptr<VulkanDevice>& device, const TimesOptions& options,
                           const std::function<void(const TimesRow&)>& measured) {
  struct Setting {
    int eyes;
    DrawMethod method;
  };
  for (const size_t kernels : options.kernels) {
    std::fprintf(stderr, "gpu-report: times: %zu kernels: binding\n", kernels);
    Bench bench(device, options);
    if (auto done = bench.make_object(kernels); !done) return done;
    for (const Setting& setting : {Setting{1, DrawMethod::Quads}, Setting{2, DrawMethod::Quads},
                                   Setting{1, DrawMethod::Tiles}, Setting{2, DrawMethod::Tiles}}) {
      std::fprintf(stderr, "gpu-report: times: %zu kernels, %s, by %s, %d x %d\n", kernels,
                   setting.eyes == 1 ? "one eye" : "two eyes", name_of(setting.method), options.width,
                   options.height);
      const auto row = bench.measure(setting.eyes, setting.method);
      if (!row && row.error().code == ErrorCode::TooLarge) {
        std::fprintf(stderr, "gpu-report: %zu kernels: %s; skipped\n", kernels, row.error().message.c_str());
        continue;
      }
      if (!row) return row.error();
      measured(*row);
    }
  }
  return {};
}

}  // namespace livegs::gpu_report
