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

#include "core/result.h"
#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/image.h"

// What a person, or a model that looks, is shown of one object: pictures from the best of a ring of cameras
// around it, drawn by the CPU rasteriser, so that what hides it is exact and no segmentation is needed.

namespace livegs {

struct ViewOptions {
  int long_side_px = 768;     // of every picture, 32 … 4096
  int view_count = 1;         // 1 fast, 3 for a vote; 1 … 12
  double aspect = 4.0 / 3;    // width over height of the scene picture, 0.5 … 2
  std::stop_token stop = {};  // looked at before every picture; once requested: Unavailable, "cancelled"
};

// One view. All pictures but the cut-out are seen by `camera` and have its size.
struct ObjectView {
  Camera camera;
  Image scene;     // everything, over a grey ground
  Image outlined;  // the same with a line around what is seen of the target
  Image mask;  // white where the target is seen; the share of each pixel's light that comes from it, 0 … 1
  Image cutout;  // the target alone, whole, filling the picture, over white; same place, longer lens
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();  // centre of the target's bounds, world frame
  double distance_m = 0;                               // from the camera to there
  double azimuth_rad = 0;    // of the camera around the target, 0 in front (+z), to the right
  double elevation_rad = 0;  // above the horizon
  double visible_share = 0;  // of the target's silhouette that nothing hides, 0 … 1
  double area_share = 0;     // of the picture that shows the target, 0 … 1
  double score = 0;          // by which the views are ordered, best first
};

// A camera of the ring, as it was judged, in the order of the ring.
struct ViewCandidate {
  double azimuth_rad = 0, elevation_rad = 0;
  double area_share = 0;     // of the picture that shows the target
  double visible_share = 0;  // of its silhouette that nothing hides
  double score = 0;          // area_share * visible_share * a bonus for seeing it upright
};

// The best views of object `object_id` among `scene`, best first and well apart. Fails when no object has
// that id, when it has nothing to draw, or when an option is out of its range. Deterministic; any thread, no
// state is kept. `candidates`, when given, receives all cameras that were tried.
Result<std::vector<ObjectView>> object_views(std::span<const DrawnObject> scene, uint32_t object_id,
                                             const ViewOptions& options = {},
                                             std::vector<ViewCandidate>* candidates = nullptr);

// Where the camera stood, in words and metres, for a person: "from the front right, 20 degrees above, …".
std::string describe_camera(const ObjectView& view);
// The same in figures, for prompts/user.md: camera_position and target_position ("x, y, z", metres, world
// frame), camera_distance (m), camera_azimuth and camera_elevation (degrees), camera_seen (percent).
std::map<std::string, std::string> camera_slots(const ObjectView& view);

}  // namespace livegs
