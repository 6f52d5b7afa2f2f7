// SPDX-License-Identifier: Apache-2.0
// Time of each step of a picture on the Vulkan device, one after the other, with an empty queue between them.
// Prints CSV: median and maximum over `frames` frames. The camera orbits a shell of kernels with three bands,
// bound to a twisted lattice of 9, 14 and 25 cells across. The warm-up has seven frames. If seven frames
// would take over a minute, as many frames are timed as fit into one minute, at least three.
// skin: the skinning pass alone. skin_rigid: the same for kernels of 1000 rigid bodies. upload: drivers, 64
// bytes per node. project (with skinning), sort and draw: as in RenderTimes; draw includes resolve and
// read-back. device_...: the passes alone, by the device's clock. Bytes are device memory per kernel with its
// share of cells and nodes, without pictures.
// Bounds: on a GPU, skinning, projecting and sorting one million kernels for both eyes takes at most 4 ms of
// device time (median). On all devices a kernel takes at most 256 bytes. The exit code is 1 if a bound is
// exceeded. Run by hand; an argument selects a single number of kernels:
//   vulkan_bench > tests/bench/results/<processor>/vulkan.csv
//   vulkan_bench KERNELS
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/skin/kernels/rest_bodies.h"
#include "common/splat/synthetic_kernels.h"
#include "compute/vulkan_backend.h"
#include "core/clock.h"
#include "core/percentile.h"
#include "gaussian/asset/posed_kernel_row.h"
#include "render/splat_renderer.h"
#include "skin/device_skin.h"
#include "splat/raster/frame_splats.h"

namespace livegs {
namespace {

constexpr int kMaxFrames = 7, kMinFrames = 3, kWarmUpFrames = 2;
constexpr double kMaxTime_s = 60;           // for the frames of a row, unless the minimum takes longer
constexpr int kWidth = 640, kHeight = 480;  // per eye
constexpr uint32_t kBodies = 1000;
constexpr double kBarBytes = 256;  // for a kernel with three bands and two eyes
constexpr size_t kBarKernels = 1'000'000;
constexpr double kBar_ms = 4;  // for skin, project and sort of kBarKernels, both eyes, on a GPU

[[noreturn]] void stop(const Error& error) {
  std::fprintf(stderr, "vulkan_bench: %s\n", error.message.c_str());
  std::exit(1);
}
template <class T>
T take(Result<T> result) {
  if (!result) stop(result.error());
  return *std::move(result);
}
void take(Result<void> result) {
  if (!result) stop(result.error());
}

struct Samples {
  std::vector<double> ms;
  double median() const { return percentile(ms, 0.5); }
  double slowest() const { return *std::max_element(ms.begin(), ms.end()); }
};

// The object as a client stores it: kernels bound to a twisted lattice, or to one of many rigid bodies.
struct Ridden {
  RestBody rest;
  KernelBindings bindings;
  ObjectDrivers drivers;
};

Ridden ride(const GaussianAsset& asset, RestBody rest) {
  Ridden ridden{std::move(rest), {}, {}};
  ridden.bindings = take(bind_kernels(asset, ridden.rest));
  return ridden;
}

Ridden ride_lattice(const GaussianAsset& asset) {
  const int across =
      static_cast<int>(std::cbrt(static_cast<double>(asset.size())) / 4);  // 25 cells for one million kernels
  const auto in_shell = [across](int x, int y, int z) {
    const double middle = (Eigen::Vector3d(x, y, z) - Eigen::Vector3d::Constant(0.5 * (across - 1))).norm();
    return middle > 0.3 * across && middle < 0.55 * across;
  };
  RestBody rest = testing::lattice_body(across, across, across, 1.0 / across, in_shell);
  rest.object_from_lattice.position_m.setConstant(-0.5);
  Ridden ridden = ride(asset, rest);
  ridden.drivers = testing::moved_drivers(rest, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return Eigen::AngleAxisd(1.5 * x.y(), Eigen::Vector3d::UnitY()) * x;
  });
  return ridden;
}

Ridden ride_bodies(const GaussianAsset& asset) {
  RestBody rest;
  synthetic::Random random(2);
  for (uint32_t b = 0; b < kBodies; ++b) rest.bodies.push_back({random.in_ball(0.5), random.rotation()});
  Ridden ridden = ride(asset, rest);
  ridden.drivers.poses = rest.bodies;
  return ridden;
}

// The pass that a client runs, on an eighth of the kernels at a time, as in a frame.
Samples skin_times(const std::shared_ptr<VulkanDevice>& device, const Ridden& ridden) {
  const auto backend = take(create_vulkan_backend(device));
  auto skin = take(DeviceSkin::create(*backend, ridden.rest, ridden.bindings));
  const uint32_t at_once = (skin.size() + 7) / 8;
  const BufferId posed = take(backend->create_buffer(at_once * sizeof(PosedKernelRow)));
  take(skin.move(ridden.rest, ridden.bindings, ridden.drivers));
  take(backend->submit());
  Samples samples;
  for (int frame = -kWarmUpFrames; frame < kMaxFrames; ++frame) {
    const int64_t begun_ns = now_ns();
    for (uint32_t first = 0, count = 0; first < skin.size(); first += count) {
      count = std::min(
          {at_once, skin.size() - first, DeviceSkin::kMaxPartKernels - first % DeviceSkin::kMaxPartKernels});
      take(skin.pose(first, count, posed));
    }
    take(backend->submit());
    if (frame >= 0) samples.ms.push_back(milliseconds_from_ns(now_ns() - begun_ns));
  }
  return samples;
}

// Bytes of kernels, of their drivers, and of per-frame data.
double bytes_a_kernel(const std::shared_ptr<VulkanDevice>& device, const GaussianAsset& asset,
                      const Ridden& ridden, size_t eyes) {
  const auto backend = take(create_vulkan_backend(device));
  const DeviceKernels kernels = take(DeviceKernels::create(*backend, asset));
  DeviceSkin skin = take(DeviceSkin::create(*backend, ridden.rest, ridden.bindings));
  take(skin.move(ridden.rest, ridden.bindings, ridden.drivers));
  const FrameSplats::Object one{&kernels, [&](uint32_t first, uint32_t count, BufferId posed) {
                                  return skin.pose(first, count, posed);
                                }};
  const std::vector<Camera> cameras(eyes);
  FrameSplats frame(*backend);
  take(frame.project({&one, 1}, cameras, {}));
  take(backend->submit());
  return static_cast<double>(kernels.device_bytes() + skin.device_bytes() + frame.device_bytes()) /
         static_cast<double>(asset.size());
}

std::vector<Camera> eyes_at(double angle_rad, int count) {
  const Eigen::Vector3d from =
      1.5 * Eigen::Vector3d(std::sin(angle_rad), 0.3, std::cos(angle_rad)).normalized();
  const Camera middle = look_at(from, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, kWidth, kHeight);
  std::vector<Camera> eyes(static_cast<size_t>(count), middle);
  for (int e = 0; e < count && count == 2; ++e) {
    eyes[e].world_from_camera =
        middle.world_from_camera * Pose{{e == 0 ? -0.032 : 0.032, 0, 0}, Eigen::Quaterniond::Identity()};
  }
  return eyes;
}

// True if the row is within its bounds.
bool measure(const std::shared_ptr<VulkanDevice>& device, const synthetic::Object& object,
             const Ridden& lattice, const Ridden& bodies, int eye_count, BlendPrecision precision) {
  const auto renderer =
      take(create_vulkan_renderer(device, {.precision = precision, .separate_times = true}));
  Samples upload, project, sort, draw, device_skin, device_project, device_sort, device_draw, device_resolve;
  std::vector<Image> images;
  int frames = kMaxFrames;
  for (int frame = -kWarmUpFrames; frame < frames; ++frame) {
    const int64_t begun_ns = now_ns();
    // A new pose in each frame, as for a moving object; the asset is uploaded once.
    const RenderedObject rendered{{&object.asset, nullptr, 0},
                                  static_cast<uint64_t>(frame + kWarmUpFrames + 1),
                                  1,
                                  {&lattice.rest, &lattice.bindings, &lattice.drivers}};
    const auto eyes = eyes_at(2.0 * M_PI * frame / frames, eye_count);
    RenderOptions options;
    options.order = DepthOrder::Distance;
    take(renderer->draw({&rendered, 1}, eyes, options, images));
    if (frame == -kWarmUpFrames) {
      const double held = kMaxTime_s / seconds_from_ns(now_ns() - begun_ns);
      frames = static_cast<int>(std::clamp(held, 1.0 * kMinFrames, 1.0 * kMaxFrames));
      if (frames < kMaxFrames) frame = -1;  // repeat the first frame as a warm-up
    }
    if (frame < 0) continue;
    const RenderTimes& times = renderer->last_times();
    upload.ms.push_back(times.upload_ms);
    project.ms.push_back(times.project_ms);
    sort.ms.push_back(times.sort_ms);
    draw.ms.push_back(times.draw_ms);
    const DeviceTimes device_times = times.device.value_or(DeviceTimes{});
    device_skin.ms.push_back(device_times.skin_ms);
    device_project.ms.push_back(device_times.project_ms);
    device_sort.ms.push_back(device_times.sort_ms);
    device_draw.ms.push_back(device_times.draw_ms);
    device_resolve.ms.push_back(device_times.resolve_ms);
  }
  Samples skin = skin_times(device, lattice), rigid = skin_times(device, bodies);
  const char* bits = precision == BlendPrecision::Half ? "16" : "32";
  std::printf("%zu,%d,%d,%d,%s,%d", object.size(), eye_count, kWidth, kHeight, bits, frames);
  for (Samples* samples : {&skin, &rigid, &upload, &project, &sort, &draw})
    std::printf(",%.2f,%.2f", samples->median(), samples->slowest());
  for (Samples* samples : {&device_skin, &device_project, &device_sort, &device_draw, &device_resolve})
    std::printf(",%.2f", samples->median());
  const double bytes = bytes_a_kernel(device, object.asset, lattice, eye_count);
  std::printf(",%.1f,%.0f\n", bytes, kBarBytes);
  std::fflush(stdout);
  // Without a device clock, host wait times are used.
  const double passes_ms = device_project.median() > 0
                               ? device_skin.median() + device_project.median() + device_sort.median()
                               : project.median() + sort.median();
  if (bytes > kBarBytes) {
    std::fprintf(stderr, "vulkan_bench: %.1f bytes per kernel exceed the bound of %.0f\n", bytes, kBarBytes);
    return false;
  }
  if (object.size() != kBarKernels || eye_count < 2 || device->is_software() || passes_ms <= kBar_ms)
    return true;
  std::fprintf(stderr,
               "vulkan_bench: %s skins, projects and sorts %zu kernels for both eyes in %.2f ms; the bound "
               "is %.0f ms\n",
               device->name().c_str(), object.size(), passes_ms, kBar_ms);
  return false;
}

int measure_all(size_t only) {
  const auto device = take(VulkanDevice::create());
  std::printf("# %s\n", device->name().c_str());
  std::printf(
      "kernels,eyes,width,height,blend_bits,frames,skin_ms,skin_max_ms,skin_rigid_ms,skin_rigid_max_ms,"
      "upload_ms,upload_max_ms,"
      "project_ms,project_max_ms,sort_ms,sort_max_ms,draw_ms,draw_max_ms,device_skin_ms,device_project_ms,"
      "device_sort_ms,"
      "device_draw_ms,device_resolve_ms,bytes_a_kernel,bar_bytes\n");
  bool held = true;
  for (const size_t count : only > 0 ? std::vector{only} : std::vector<size_t>{50'000, 200'000, 1'000'000}) {
    // Kernels shrink with their number, so that the opacity of the shell stays the same.
    const synthetic::Object object =
        synthetic::shell(count, 3, 0.9 / std::sqrt(static_cast<double>(count)), 1);
    const Ridden lattice = ride_lattice(object.asset), bodies = ride_bodies(object.asset);
    for (const int eyes : {1, 2})
      held = measure(device, object, lattice, bodies, eyes, BlendPrecision::Half) && held;
    held = measure(device, object, lattice, bodies, 1, BlendPrecision::Full) && held;
  }
  return held ? 0 : 1;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) {
  return livegs::measure_all(argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 0);
}
