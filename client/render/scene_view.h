// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "render/splat_renderer.h"
#include "skin/driver_frame.h"
#include "skin/skin_kernels.h"

namespace livegs {

// Behind a scene without walls, as `livegs render` has it.
inline const Eigen::Vector3f kBackground{0.08f, 0.08f, 0.1f};

// The objects of a scene as a client holds them, and how they look for a given frame of drivers. Kernels of
// an object whose drivers are bit for bit those of the last picture are not skinned again. Not locked.
class SceneView {
 public:
  explicit SceneView(std::unique_ptr<SplatRenderer> renderer = create_cpu_renderer())
      : renderer_(std::move(renderer)) {}

  // Ties the kernels to their drivers: about 0.1 s for 300k kernels. An id that is there already is replaced.
  Result<void> add(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                   bool environment);
  // The same for an object that broke. Frames that name an earlier revision are drawn as before, until one of
  // the new revision was; so are all frames if the revision is not a new one.
  Result<void> change(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                      bool environment);
  void remove(uint32_t object_id);

  // An image an eye, of one eye or two. Objects of the frame that were never added are left out; drivers that
  // do not fit their object are an error. A renderer that fails (a lost device, one that cannot hold the scene)
  // is replaced by the CPU's, with a warning.
  Result<void> draw(const DriverFrame& frame, std::span<const Camera> eyes, std::vector<Image>& images);

  // The same into an image on the renderer's device; where it cannot, into `images`, which are empty else.
  Result<void> draw_into(const DriverFrame& frame, std::span<const Camera> eyes, const DeviceImage& image,
                         std::vector<Image>& images);

  // Kernels that add less to a picture are left out from now on (RenderOptions); 0, as at first: none.
  void set_min_contribution(float min_contribution_px) { min_contribution_px_ = min_contribution_px; }

  // The last picture's moment by another renderer: the CPU's, to hold the picture against.
  Result<void> draw_again(SplatRenderer& renderer, std::span<const Camera> eyes, std::vector<Image>& images) const;

  struct Times {
    double skin_ms = 0, raster_ms = 0;
    size_t objects_skinned = 0;
    std::optional<DeviceTimes> device;
  };
  const Times& last_times() const { return times_; }
  const std::string& renderer_name() const { return renderer_->name(); }
  std::string notice() const { return renderer_->notice(); }  // as SplatRenderer has it

  // What the last picture shows, or pose() posed.
  std::vector<DrawnObject> drawn() const;

  // World bounds of each object (never the environment) as it stands in the last picture, or after pose():
  // from the 1st to the 99th percentile of its kernels along each axis, so that haze and floaters do not
  // count.
  std::vector<Eigen::AlignedBox3d> object_boxes() const;
  Eigen::AlignedBox3d bounds(uint32_t object_id) const;  // empty if unknown
  // The mean of the environment's kernels; nothing when there is none.
  std::optional<Eigen::Vector3d> environment_middle() const;

  // The thing that a ray meets in the last picture, the environment included. `direction` is unit.
  struct Picked {
    uint32_t object_id = 0;
    bool environment = false;
    size_t kernel = 0;
    Eigen::Vector3d point_m;       // on the ray
    Eigen::Vector3d rest_point_m;  // of the kernel, in the object's frame: a force's point
  };
  std::optional<Picked> pick(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const;
  // The kernel of an object that lies nearest to a point of its frame at rest; nothing for what is not there.
  std::optional<size_t> nearest_kernel(uint32_t object_id, const Eigen::Vector3d& rest_point_m) const;
  // Where a kernel of the last picture is; nothing if it is not there any more.
  std::optional<Eigen::Vector3d> kernel_position_m(uint32_t object_id, size_t kernel) const;

  // Skins without drawing.
  Result<void> pose(const DriverFrame& frame);

 private:
  // An object as of one revision.
  struct Object {
    std::shared_ptr<const GaussianAsset> asset;
    RestBody rest;
    KernelBindings bindings;
    bool environment = false;
    PosedKernels kernels;
    std::optional<ObjectDrivers> posed_by;
    uint64_t posed_version = 0, asset_version = 0;  // as RenderedObject has them
  };

  Result<void> draw(std::span<const Camera> eyes, const DeviceImage* image, std::vector<Image>& images);
  std::vector<RenderedObject> rendered() const;
  const Object* shown(uint32_t object_id) const;  // the oldest revision, which is that of the last pose

  std::map<uint32_t, std::map<uint32_t, Object>> objects_;  // by id, then revision
  std::vector<uint32_t> visible_;                           // ids of the last pose, ascending
  std::unique_ptr<SplatRenderer> renderer_;
  bool draws_on_cpu_ = false;  // because the renderer could not
  float min_contribution_px_ = 0;
  uint64_t last_version_ = 0;
  Times times_;
};

}  // namespace livegs
