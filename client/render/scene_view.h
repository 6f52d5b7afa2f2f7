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
#include "skin/shape_sample.h"
#include "skin/skin_kernels.h"
#include "splat/shadow_table.h"

namespace livegs {

// Background of a scene without an environment, as in `livegs render`.
inline const Eigen::Vector3f kBackground{0.08f, 0.08f, 0.1f};

// The objects of a scene on the client, posed and drawn from frames of drivers or kernels. A renderer that
// skins (Vulkan) receives drivers. Otherwise kernels are skinned here on demand, per object, and only if the
// drivers differ from those of the last skinning. Not thread-safe, including const functions.
class SceneView {
 public:
  explicit SceneView(std::unique_ptr<SplatRenderer> renderer = create_cpu_renderer())
      : renderer_(std::move(renderer)) {}

  // Binds the kernels to their drivers: about 0.1 s for 300k kernels. An existing id is replaced.
  Result<void> add(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                   bool environment);
  // The same for a fractured object. Frames of an earlier revision are drawn as before until the first frame
  // of the new revision; so are all frames if the revision is not new.
  Result<void> change(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                      bool environment);
  // The same for the result of bind_object(), without the delay.
  void add(uint32_t object_id, BoundObject object);
  void change(uint32_t object_id, BoundObject object);
  bool has(uint32_t object_id, uint32_t revision) const;
  // Replaces the same revision of an object by one with more kernels, keeping the pose. No effect for an
  // unknown object.
  void refine(uint32_t object_id, BoundObject object);
  // The kernels of an object as they are drawn; null for an unknown object.
  std::shared_ptr<const GaussianAsset> asset(uint32_t object_id) const;
  // Replaces them by the same kernels in other colours, keeping the pose. No effect for an unknown object.
  void recolour(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset);
  void remove(uint32_t object_id);

  // Draws one image per eye, for one or two eyes. Unknown objects of the frame are skipped. An object whose
  // drivers belong to a later revision keeps its pose; drivers that do not fit their object are an error. If
  // the renderer fails (device lost or out of memory), the CPU renderer replaces it, with a warning and a
  // notice.
  Result<void> draw(const DriverFrame& frame, std::span<const Camera> eyes, std::vector<Image>& images);

  // The same in the pose of the last pose() or draw().
  Result<void> draw(std::span<const Camera> eyes, std::vector<Image>& images);

  // The same into an image on the renderer's device; if it cannot, into `images`, which are empty otherwise.
  Result<void> draw_into(const DriverFrame& frame, std::span<const Camera> eyes, const DeviceImage& image,
                         std::vector<Image>& images);

  // Skips kernels that contribute less to a picture (RenderOptions); 0, the default: none. Also limits the
  // radius of kernels to the longer side of the picture, or twice that by default. Errors of both limits:
  // tests/bench/results, cap.csv.
  void set_min_contribution(float min_contribution_px) { min_contribution_px_ = min_contribution_px; }

  // Whether objects darken other objects and the environment under and around them; true by default.
  void set_shadows(bool drawn) { draws_shadows_ = drawn; }

  // Colour where nothing is, display-encoded, 0 to 1; nothing: the default, a dark grey.
  void set_background(const std::optional<Eigen::Vector3f>& rgb);

  // Draws the last picture with another renderer, for a comparison with the CPU.
  Result<void> draw_again(SplatRenderer& renderer, std::span<const Camera> eyes,
                          std::vector<Image>& images) const;

  // Changes whenever a picture of the same camera and renderer may change: with pose(), and with added,
  // refined and removed objects.
  uint64_t version() const { return last_version_; }

  struct Times {
    double skin_ms = 0;                             // kernels skinned here since the last pose()
    double shadow_ms = 0;                           // shadows of objects that moved, likewise
    size_t objects_moved = 0, objects_skinned = 0;  // since the last pose()
    double raster_ms = 0;                           // of the last picture, like the next
    std::optional<DeviceTimes> device;
  };
  const Times& last_times() const { return times_; }
  const std::string& renderer_name() const { return renderer_->name(); }
  std::string notice() const { return renderer_->notice(); }  // see SplatRenderer

  // Objects of the last picture, or of pose(), whose kernels may lie in a box; or one such object, if
  // visible.
  std::vector<DrawnObject> drawn_near(const Eigen::AlignedBox3f& box_m) const;
  std::optional<DrawnObject> drawn_object(uint32_t object_id) const;

  // World bounds of each object (without the environment) in the last picture or after pose(): from the 1st
  // to the 99th percentile of its kernels along each axis, which excludes haze and floaters.
  std::vector<Eigen::AlignedBox3d> object_boxes() const;
  Eigen::AlignedBox3d bounds(uint32_t object_id) const;  // empty for an unknown id
  // Mean of the environment's kernels; nothing without an environment.
  std::optional<Eigen::Vector3d> environment_middle() const;

  // First object that a ray hits in the last picture, environment included. `direction` is a unit vector.
  struct Picked {
    uint32_t object_id = 0;
    bool environment = false;
    size_t kernel = 0;
    Eigen::Vector3d point_m;       // on the ray
    Eigen::Vector3d rest_point_m;  // rest position of the kernel, object frame, to apply a force at
  };
  std::optional<Picked> pick(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const;
  // The kernel of an object nearest to a point in its rest frame; nothing for an unknown object.
  std::optional<size_t> nearest_kernel(uint32_t object_id, const Eigen::Vector3d& rest_point_m) const;
  // Position of a kernel in the last picture; nothing if it no longer exists.
  std::optional<Eigen::Vector3d> kernel_position_m(uint32_t object_id, size_t kernel) const;

  // Sets the pose without drawing.
  Result<void> pose(const DriverFrame& frame);
  // Sets the pose and skins in advance what drawing will need, so that the head pose can be sampled later.
  Result<void> prepare(const DriverFrame& frame);

 private:
  // One revision of an object.
  struct Object {
    std::shared_ptr<const GaussianAsset> asset;
    RestBody rest;
    KernelBindings bindings;
    KernelReach reach;
    ShapeSample shape;
    bool environment = false;
    std::optional<ObjectDrivers> posed_by;
    uint64_t posed_version = 0, asset_version = 0;  // as in RenderedObject
    uint64_t shadow_version = 0;                    // posed_version of the shadow
    mutable PosedKernels kernels;                   // valid for the pose of `skinned_version`
    mutable uint64_t skinned_version = 0;
  };

  Result<void> draw(std::span<const Camera> eyes, const DeviceImage* image, std::vector<Image>& images);
  std::vector<RenderedObject> rendered(const SplatRenderer& renderer) const;
  void cast_shadows();                                         // of the visible objects, as posed
  const PosedKernels& kernels_of(const Object& object) const;  // current positions
  DrawnObject drawn(uint32_t object_id) const;                 // the visible revision
  RenderOptions options_for(std::span<const Camera> eyes) const;
  const Object* shown(uint32_t object_id) const;  // the oldest revision, that of the last pose

  std::map<uint32_t, std::map<uint32_t, Object>> objects_;  // by id, then revision
  std::vector<uint32_t> visible_;                           // ids of the last pose, ascending
  std::unique_ptr<SplatRenderer> renderer_;
  bool draws_on_cpu_ = false;  // after a failure of the renderer
  float min_contribution_px_ = 0;
  bool draws_shadows_ = true;
  SceneShadows shadows_;
  const ShadowTable* shadow_table_ = nullptr;  // of `shadows_`, if drawn
  std::optional<Eigen::Vector3f> background_rgb_;
  uint64_t last_version_ = 0;  // of an object's pose or asset, or of the set of objects
  mutable Times times_;
};

}  // namespace livegs
