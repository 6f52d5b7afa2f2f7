// SPDX-License-Identifier: Apache-2.0
// What each step of a picture costs on the Vulkan device found, one after the other, the queue empty between
// them. Prints a CSV: medians and the slowest of a few frames in which the camera walks around a shell of
// kernels with three bands, after a warm-up. skin: the pass that poses rigid kernels, of a thousand bodies;
// upload: what skinning on the CPU costs on top, 52 bytes a kernel; project, sort and draw as RenderTimes has
// them, draw with resolve and reading back; device_...: the passes alone, by the device's clock. Bytes are those of a kernel on the device, pictures left out. Run
// by hand:
//   vulkan_bench > tests/bench/results/<processor>/vulkan.csv
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "common/splat/synthetic_kernels.h"
#include "compute/vulkan_backend.h"
#include "core/clock.h"
#include "render/splat_renderer.h"
#include "skin/pose_rigid_kernels.h"
#include "splat/frame_splats.h"

namespace livegs {
namespace {

constexpr int kFrames = 7, kWarmUpFrames = 2;
constexpr int kWidth = 640, kHeight = 480;  // of an eye
constexpr uint32_t kBodies = 1000;

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
  double median() {
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() / 2];
  }
  double slowest() const { return *std::max_element(ms.begin(), ms.end()); }
};

Samples skin_times(const std::shared_ptr<VulkanDevice>& device, uint32_t count) {
  const auto backend = take(create_vulkan_backend(device));
  const BufferId rest = take(backend->create_buffer(count * sizeof(RigidKernelRow)));
  const BufferId posed = take(backend->create_buffer(count * sizeof(RigidKernelRow)));
  const BufferId poses = take(backend->create_buffer(kBodies * sizeof(RigidPoseRows)));
  std::vector<RigidKernelRow> rows(count);
  for (uint32_t i = 0; i < count; ++i)
    rows[i] = {0.1f, 0.2f, 0.3f, i % kBodies, 1e-4f, 0, 0, 1e-4f, 0, 1e-4f, 0, 0};
  const std::vector<RigidPoseRows> turns(kBodies, {0, -1, 0, 0.5f, 1, 0, 0, 0, 0, 0, 1, 0});
  take(backend->upload(rest, std::as_bytes(std::span(rows))));
  take(backend->upload(poses, std::as_bytes(std::span(turns))));
  Samples samples;
  for (int frame = -kWarmUpFrames; frame < kFrames; ++frame) {
    const int64_t begun_ns = now_ns();
    take(dispatch_pose_rigid_kernels(*backend, {rest, poses, posed, count, kBodies}));
    take(backend->submit());
    if (frame >= 0) samples.ms.push_back(milliseconds_from_ns(now_ns() - begun_ns));
  }
  return samples;
}

// Of the kernels themselves, and of what a frame keeps of each.
double bytes_a_kernel(const std::shared_ptr<VulkanDevice>& device, const GaussianAsset& asset, size_t eyes) {
  const auto backend = take(create_vulkan_backend(device));
  const DeviceKernels kernels = take(DeviceKernels::create(*backend, asset));
  const std::vector<Camera> cameras(eyes);
  const DeviceKernels* one = &kernels;
  FrameSplats frame(*backend);
  take(frame.project({&one, 1}, cameras, {}));
  return static_cast<double>(kernels.device_bytes() + frame.device_bytes()) /
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

void measure(const std::shared_ptr<VulkanDevice>& device, const synthetic::Object& object, int eye_count,
             BlendPrecision precision) {
  const auto renderer =
      take(create_vulkan_renderer(device, {.precision = precision, .separate_times = true}));
  Samples upload, project, sort, draw, device_project, device_sort, device_draw, device_resolve;
  std::vector<Image> images;
  for (int frame = -kWarmUpFrames; frame < kFrames; ++frame) {
    // A new place each frame, as of what moves; the asset is uploaded once.
    const RenderedObject rendered{object.drawn(), static_cast<uint64_t>(frame + kWarmUpFrames + 1), 1};
    const auto eyes = eyes_at(2.0 * M_PI * frame / kFrames, eye_count);
    RenderOptions options;
    options.order = DepthOrder::Distance;
    take(renderer->draw({&rendered, 1}, eyes, options, images));
    if (frame < 0) continue;
    const RenderTimes& times = renderer->last_times();
    upload.ms.push_back(times.upload_ms);
    project.ms.push_back(times.project_ms);
    sort.ms.push_back(times.sort_ms);
    draw.ms.push_back(times.draw_ms);
    const DeviceTimes device_times = times.device.value_or(DeviceTimes{});
    device_project.ms.push_back(device_times.project_ms);
    device_sort.ms.push_back(device_times.sort_ms);
    device_draw.ms.push_back(device_times.draw_ms);
    device_resolve.ms.push_back(device_times.resolve_ms);
  }
  Samples skin = skin_times(device, static_cast<uint32_t>(object.size()));
  std::printf("%zu,%d,%d,%d,%s,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.1f\n", object.size(),
              eye_count, kWidth, kHeight, precision == BlendPrecision::Half ? "16" : "32", skin.median(),
              skin.slowest(), upload.median(), upload.slowest(), project.median(), project.slowest(),
              sort.median(), sort.slowest(), draw.median(), draw.slowest(), device_project.median(), device_sort.median(),
              device_draw.median(), device_resolve.median(),
              bytes_a_kernel(device, object.asset, eye_count));
  std::fflush(stdout);
}

void measure_all() {
  const auto device = take(VulkanDevice::create());
  std::printf("# %s\n", device->name().c_str());
  std::printf(
      "kernels,eyes,width,height,blend_bits,skin_ms,skin_max_ms,upload_ms,upload_max_ms,project_ms,project_"
      "max_ms,"
      "sort_ms,sort_max_ms,draw_ms,draw_max_ms,device_project_ms,device_sort_ms,device_draw_ms,device_resolve_ms,"
      "bytes_a_kernel\n");
  for (const size_t count : {50'000u, 200'000u, 1'000'000u}) {
    // Kernels shrink as they grow in number, so that the shell stays as opaque.
    const synthetic::Object object =
        synthetic::shell(count, 3, 0.9 / std::sqrt(static_cast<double>(count)), 1);
    for (const int eyes : {1, 2}) measure(device, object, eyes, BlendPrecision::Half);
    measure(device, object, 1, BlendPrecision::Full);
  }
}

}  // namespace
}  // namespace livegs

int main() { livegs::measure_all(); }
