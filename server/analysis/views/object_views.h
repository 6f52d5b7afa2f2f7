// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "analysis/division/picture_votes.h"
#include "core/result.h"
#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/image.h"

// Pictures of one object for a user or a vision model. The best cameras of a ring around the object are
// selected. The CPU rasteriser draws the pictures, so occlusion is exact and no segmentation is needed.

namespace livegs {

struct ViewOptions {
  int long_side_px = 768;     // of every picture, 32 … 4096
  int view_count = 1;         // 1 fast, 3 for a vote; 1 … 12
  double aspect = 4.0 / 3;    // width over height of the scene picture, 0.5 … 2
  std::stop_token stop = {};  // checked before every picture; if requested: Unavailable, "cancelled"
  size_t sight_stride = 0;    // of the kernels of SurfaceKernels; 0: no sights
};

// One view. All pictures except the cut-out are taken by `camera`, are cropped to the target with a margin of
// a quarter of its extent, and have the camera's size.
struct ObjectView {
  Camera camera;
  Image scene;     // everything, over a grey ground
  Image outlined;  // the same with an outline of the visible part of the target
  Image mask;      // fraction of each pixel's light from the target, 0 … 1 (white)
  // The whole target alone, filling the picture, over white: from the camera of the ring that shows the most
  // of the surface that `camera` does not show.
  Image cutout;
  // Visible kernels of `outlined` and `cutout`; empty unless ViewOptions::sight_stride is set.
  std::vector<PictureSights> sights;
  double cutout_azimuth_rad = 0, cutout_elevation_rad = 0;  // as those below
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();       // centre of the target's bounds, world frame
  double distance_m = 0;                                    // from the camera to `target_m`
  double azimuth_rad = 0;    // of the camera around the target; 0 in front (+z), positive to the right
  double elevation_rad = 0;  // above the horizon
  double visible_share = 0;  // unoccluded fraction of the target's silhouette, 0 … 1
  double area_share = 0;     // fraction of the picture covered by the target, 0 … 1
  double score = 0;          // the first view has the highest
};

// A candidate camera of the ring with its score, in ring order.
struct ViewCandidate {
  double azimuth_rad = 0, elevation_rad = 0;
  double area_share = 0;     // fraction of the picture covered by the target
  double visible_share = 0;  // unoccluded fraction of its silhouette
  double score = 0;          // area_share * visible_share * a bonus for an upright view
};

// Renders views of object `object_id` in `scene`, well separated: the best one, then those that show the most
// of the surface that the ones before do not show. Fails if no object has that id, if it has no kernels to
// draw, or if an option is out of range. Deterministic; any thread, stateless. `candidates`, if given,
// receives all cameras that were tried.
Result<std::vector<ObjectView>> object_views(std::span<const DrawnObject> scene, uint32_t object_id,
                                             const ViewOptions& options = {},
                                             std::vector<ViewCandidate>* candidates = nullptr);

// Describes the camera position for a user: "from the front right, 20 degrees above, …".
std::string describe_camera(const ObjectView& view);
// Numeric camera slots for prompts/user.md: camera_azimuth and camera_elevation (degrees), camera_seen
// (percent), second_azimuth and second_elevation (degrees, of the cut-out).
std::map<std::string, std::string> camera_slots(const ObjectView& view);

}  // namespace livegs
