// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compute/device_image.h"
#include "compute/vulkan_device.h"
#include "gaussian/posed_kernels.h"
#include "render/blend_precision.h"
#include "skin/skin_kernels.h"
#include "splat/camera.h"
#include "splat/image.h"
#include "splat/rasterise.h"

namespace livegs {

// What skin_kernels takes, for a renderer that skins kernels itself. All outlive the call they are given to.
struct SkinnedBy {
  const RestBody* rest = nullptr;
  const KernelBindings* bindings = nullptr;  // of the asset and `rest`
  const ObjectDrivers* drivers = nullptr;    // that fit `rest`
};

// One object of a picture, and what of it a renderer may keep from the last picture.
struct RenderedObject {
  DrawnObject
      drawn;  // drawn.kernels may be null where `skinned_by` is given and the renderer skins that kind
  // Equal numbers, equal kernels: of where they are, and of what asset they are. Never 0.
  uint64_t posed_version = 0;
  uint64_t asset_version = 0;
  SkinnedBy skinned_by{};  // all of it or nothing
};

struct RenderOptions {
  Eigen::Vector3f background{0, 0, 0};
  DepthOrder order =
      DepthOrder::ViewZ;  // of two eyes Distance is from between them, ViewZ along what both look along
  int max_sh_degree = 3;
  float max_radius_px = 0;        // as eye_view has it; 0: none
  float min_contribution_px = 0;  // as eye_view has it; 0: all are drawn
};

// Of the passes alone, by the device's own clock.
struct DeviceTimes {
  double skin_ms = 0, project_ms = 0, sort_ms = 0, draw_ms = 0, resolve_ms = 0;
  double total_ms() const { return skin_ms + project_ms + sort_ms + draw_ms + resolve_ms; }
};

// By the caller's clock: what it waited for. Without separate_times a Vulkan device does all of it in
// draw_ms. What it skins is skinned in project_ms.
struct RenderTimes {
  double upload_ms = 0, project_ms = 0, sort_ms = 0, draw_ms = 0;
  std::optional<DeviceTimes> device;             // where it has a clock
  uint64_t uploaded_bytes = 0, submissions = 0;  // to a device, of this picture
  int eyes_a_draw = 1;                           // 2: one draw covered both eyes
  double total_ms() const { return upload_ms + project_ms + sort_ms + draw_ms; }
};

// Draws objects, each with an id of its own, in one sorted set, for one eye or two of one size. One thread at
// a time.
class SplatRenderer {
 public:
  virtual ~SplatRenderer() = default;
  virtual const std::string& name() const = 0;  // "cpu", or "vulkan: " and the device's name

  // An image an eye: display-encoded, over the background, alpha is coverage. What is not among the objects
  // of this picture is forgotten.
  virtual Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                            const RenderOptions& options, std::vector<Image>& images) = 0;
  // The same into a layer an eye of an image on the renderer's own device; Unsupported by one that has none.
  virtual Result<void> draw_into(std::span<const RenderedObject>, std::span<const Camera>,
                                 const RenderOptions&, const DeviceImage&) {
    return unsupported(name() + ": draws into no device's image");
  }
  // Whether it skins kernels of this kind itself, from `skinned_by` alone.
  virtual bool skins(DriverKind) const { return false; }
  virtual const RenderTimes& last_times() const = 0;
  // What is out of order with its pictures, for a person to read; empty when nothing is.
  virtual std::string notice() const { return {}; }
};

// The oracle, on the threads of parallel_for; eyes one after the other.
std::unique_ptr<SplatRenderer> create_cpu_renderer();
// The same in the place of a renderer that failed: its notice says so.
std::unique_ptr<SplatRenderer> create_cpu_renderer_instead_of(const std::string& device, const Error& why);

struct VulkanRendererOptions {
  BlendPrecision precision = BlendPrecision::Auto;
  bool separate_times = false;  // waits between the steps, so that last_times tells them apart
  bool read_blended = false;    // images as they were blended, before 8 bits a channel: for measuring
  uint32_t max_part_rows = 0;   // as FrameSplats has it; 0: what the device binds
};
// Unavailable where the device cannot draw.
Result<std::unique_ptr<SplatRenderer>> create_vulkan_renderer(std::shared_ptr<VulkanDevice> device,
                                                              const VulkanRendererOptions& options = {});

}  // namespace livegs
