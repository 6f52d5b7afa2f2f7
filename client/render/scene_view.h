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
#include "render/view/bound_object.h"
#include "skin/driver_frame.h"
#include "skin/kernels/kernel_reach.h"
#include "skin/skin_kernels.h"

namespace livegs {

// Behind a scene without walls, as `livegs render` has it.
inline const Eigen::Vector3f kBackground{0.08f, 0.08f, 0.1f};

// The objects of a scene as a client holds them, and how they look for a given frame of drivers, or of
// kernels. A renderer that skins (Vulkan's) is given drivers; kernels are skinned here only for who asks
// where they are, object by object, and only if its drivers are not bit for bit those they were last skinned
// for. Not locked, const or not.
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
  // The same of what bind_object() has tied, without the wait.
  void add(uint32_t object_id, BoundObject object);
  void change(uint32_t object_id, BoundObject object);
  bool has(uint32_t object_id, uint32_t revision) const;
  // The same revision of an object with more of its kernels, as they come; posed as it is. Nothing happens to
  // one that is not there.
  void refine(uint32_t object_id, BoundObject object);
  void remove(uint32_t object_id);

  // An image an eye, of one eye or two. Objects of the frame that were never added are left out; one whose
  // drivers are of a revision that is yet to come stands as it did; drivers that do not fit their object are
  // an error. A renderer that fails (a lost device, one that cannot hold the scene) is replaced by the CPU's,
  // with a warning and a notice.
  Result<void> draw(const DriverFrame& frame, std::span<const Camera> eyes, std::vector<Image>& images);

  // The same into an image on the renderer's device; where it cannot, into `images`, which are empty else.
  Result<void> draw_into(const DriverFrame& frame, std::span<const Camera> eyes, const DeviceImage& image,
                         std::vector<Image>& images);

  // Kernels that add less to a picture are left out from now on (RenderOptions); 0, as at first: none. Then,
  // too, one that is seen larger than the longer side of the picture is shrunk to that, else to twice as
  // much: from outside of captured assets neither changes a bit, from inside the first leaves 42 dB and more
  // and the second 56 (cap.csv).
  void set_min_contribution(float min_contribution_px) { min_contribution_px_ = min_contribution_px; }

  // The last picture's moment by another renderer: the CPU's, to hold the picture against.
  Result<void> draw_again(SplatRenderer& renderer, std::span<const Camera> eyes,
                          std::vector<Image>& images) const;

  struct Times {
    double skin_ms = 0;                             // of kernels skinned here since the last pose()
    size_t objects_moved = 0, objects_skinned = 0;  // likewise
    double raster_ms = 0;                           // of the last picture, as the next
    std::optional<DeviceTimes> device;
  };
  const Times& last_times() const { return times_; }
  const std::string& renderer_name() const { return renderer_->name(); }
  std::string notice() const { return renderer_->notice(); }  // as SplatRenderer has it

  // What the last picture shows, or pose() posed, as far as kernels of it may be within a box; one object of
  // it, if shown.
  std::vector<DrawnObject> drawn_near(const Eigen::AlignedBox3f& box_m) const;
  std::optional<DrawnObject> drawn_object(uint32_t object_id) const;

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

  // Goes to a moment without drawing it.
  Result<void> pose(const DriverFrame& frame);
  // The same, and skins what drawing it will ask for, for who looks up the head after that.
  Result<void> prepare(const DriverFrame& frame);

 private:
  // An object as of one revision.
  struct Object {
    std::shared_ptr<const GaussianAsset> asset;
    RestBody rest;
    KernelBindings bindings;
    KernelReach reach;
    bool environment = false;
    std::optional<ObjectDrivers> posed_by;
    uint64_t posed_version = 0, asset_version = 0;  // as RenderedObject has them
    mutable PosedKernels kernels;                   // of the moment `skinned_version` was the posed one
    mutable uint64_t skinned_version = 0;
  };

  Result<void> draw(std::span<const Camera> eyes, const DeviceImage* image, std::vector<Image>& images);
  std::vector<RenderedObject> rendered(const SplatRenderer& renderer) const;
  const PosedKernels& kernels_of(const Object& object) const;  // where they are now
  DrawnObject drawn(uint32_t object_id) const;                 // of what is shown
  RenderOptions options_for(std::span<const Camera> eyes) const;
  const Object* shown(uint32_t object_id) const;  // the oldest revision, which is that of the last pose

  std::map<uint32_t, std::map<uint32_t, Object>> objects_;  // by id, then revision
  std::vector<uint32_t> visible_;                           // ids of the last pose, ascending
  std::unique_ptr<SplatRenderer> renderer_;
  bool draws_on_cpu_ = false;  // because the renderer could not
  float min_contribution_px_ = 0;
  uint64_t last_version_ = 0;
  mutable Times times_;
};

}  // namespace livegs
