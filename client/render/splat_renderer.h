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

// Inputs of skin_kernels for a renderer that skins kernels itself. All must outlive the call.
struct SkinnedBy {
  const RestBody* rest = nullptr;
  const KernelBindings* bindings = nullptr;  // for the asset and `rest`
  const ObjectDrivers* drivers = nullptr;    // matching `rest`
};

// One object of a picture, with versions that allow a renderer to reuse data of the last picture.
struct RenderedObject {
  // drawn.kernels may be null if `skinned_by` is set and the renderer skins that kind.
  DrawnObject drawn;
  // Equal versions mean equal positions and an equal asset. Never 0.
  uint64_t posed_version = 0;
  uint64_t asset_version = 0;
  SkinnedBy skinned_by{};  // complete or empty
};

struct RenderOptions {
  Eigen::Vector3f background{0, 0, 0};
  // For two eyes: Distance is measured from the point between them, ViewZ along their common axis.
  DepthOrder order = DepthOrder::ViewZ;
  int max_sh_degree = 3;
  float max_radius_px = 0;                  // as in eye_view; 0: no limit
  float min_contribution_px = 0;            // as in eye_view; 0: all kernels are drawn
  const ShadowTable* shadows = nullptr;     // of one SceneShadows, by object id; null: none
  std::vector<uint32_t> environments = {};  // object ids, see kEnvironmentOrderBias
};

// Device time of the passes. With tiles, draw is binning and resolve is blending.
struct DeviceTimes {
  double skin_ms = 0, project_ms = 0, sort_ms = 0, draw_ms = 0, resolve_ms = 0;
  double total_ms() const { return skin_ms + project_ms + sort_ms + draw_ms + resolve_ms; }
};

// Time that the caller waited. Without separate_times, a Vulkan device reports all of it in draw_ms. Skinning
// is part of project_ms.
struct RenderTimes {
  double upload_ms = 0, project_ms = 0, sort_ms = 0, draw_ms = 0;
  std::optional<DeviceTimes> device;             // if the device has a timer
  uint64_t uploaded_bytes = 0, submissions = 0;  // to the device, for this picture
  uint64_t dispatches = 0, barriers = 0;         // barriers of memory, without layout changes of images
  int eyes_a_draw = 1;                           // 2: one draw covers both eyes
  double total_ms() const { return upload_ms + project_ms + sort_ms + draw_ms; }
};

// Draws objects with unique ids in one sorted set, for one eye or for two of equal size. One thread at a
// time.
class SplatRenderer {
 public:
  virtual ~SplatRenderer() = default;
  virtual const std::string& name() const = 0;  // "cpu", or "vulkan: " and the device's name

  // Draws one image per eye: display-encoded, over the background; alpha is coverage. Cached data of objects
  // that are not in the picture is discarded.
  virtual Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                            const RenderOptions& options, std::vector<Image>& images) = 0;
  // The same into one layer per eye of an image on the renderer's device; Unsupported without a device.
  virtual Result<void> draw_into(std::span<const RenderedObject>, std::span<const Camera>,
                                 const RenderOptions&, const DeviceImage&) {
    return unsupported(name() + ": cannot draw into a device image");
  }
  // Whether it skins kernels of this kind, given `skinned_by` only.
  virtual bool skins(DriverKind) const { return false; }
  virtual const RenderTimes& last_times() const = 0;
  // A problem with the pictures, for display to the user; empty if none.
  virtual std::string notice() const { return {}; }
};

// The reference, on the threads of parallel_for; eyes are drawn one after the other.
std::unique_ptr<SplatRenderer> create_cpu_renderer();
// The same as a replacement of a renderer that failed, with a notice.
std::unique_ptr<SplatRenderer> create_cpu_renderer_instead_of(const std::string& device, const Error& why);

// Quads: the kernels as instanced quads through the device's rasteriser. Tiles: compute passes alone, with
// an end at opaque pixels, in 32-bit floats. Auto: the faster for a test picture.
enum class DrawMethod : uint8_t { Auto, Quads, Tiles };
inline const char* name_of(DrawMethod method) {
  return method == DrawMethod::Auto ? "auto" : method == DrawMethod::Tiles ? "tiles" : "quads";
}

struct VulkanRendererOptions {
  DrawMethod method = DrawMethod::Auto;
  BlendPrecision precision = BlendPrecision::Auto;  // of quads
  bool separate_times = false;  // waits between the steps, so that last_times has separate values
  bool read_blended = false;    // images before the conversion to 8 bits, for measurements
  uint32_t max_part_rows = 0;   // as in FrameSplats; 0: the device's limit
};
// Unavailable for quads if the device cannot draw; a device with compute alone draws by tiles.
Result<std::unique_ptr<SplatRenderer>> create_vulkan_renderer(std::shared_ptr<VulkanDevice> device,
                                                              const VulkanRendererOptions& options = {});

}  // namespace livegs
