// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "parts/planes/support_planes.h"
#include "splat/camera.h"

// Finds the things in a captured room without masks or neural networks: depth from views, large planes,
// connected voxels above them, and labels lifted to the kernels by alpha times transmittance.
//
// The frame and the unit of length are those of the asset; names of lengths end in _m. All sizes follow from
// the footprint of a pixel on the surfaces, so results do not depend on the unit. Any thread; deterministic.

namespace livegs {

inline constexpr uint16_t kRoomLabel = 0;
inline constexpr size_t kMaxParts = 4000;

struct PartsOptions {
  Eigen::Vector3d up{0, -1, 0};  // unit, within 20 degrees of the vertical
  // Cameras of the photos. Empty: views are chosen by the kernels in sight.
  std::vector<Camera> cameras;
  size_t max_views = 48;  // of the cameras, evenly taken, or of chosen views
  int view_width = 320;   // px; larger cameras are scaled down to it. The unit of all sizes is a pixel
  std::stop_token stop;
  std::function<void(const char* step, double fraction)> progress;
};

struct RoomPart {
  uint16_t label = 0;  // i + 1 for part i
  size_t kernel_count = 0;
  size_t voxel_count = 0;
  std::optional<size_t> support;  // index of the plane it rests on, alone or in a stack
  std::optional<size_t> wall;     // index of a wall that it touches
  Eigen::Vector3f mean_rgb{0, 0, 0};
};

struct RoomParts {
  std::vector<uint16_t> label;  // per kernel; kRoomLabel: the room
  std::vector<float> share;     // per kernel: share of its label in its visible weight; 0: never seen
  std::vector<RoomPart> parts;
  RoomPlanes planes;
  std::vector<Camera> cameras;                  // views that were used
  std::vector<std::vector<uint16_t>> pictures;  // their label pictures
  double footprint_m = 0;                       // median edge of a pixel on the surfaces
  double voxel_m = 0;
  double lowest_m = 0;  // height along `up` below which almost nothing is seen
};

// Fails with InvalidArgument or InvalidData if nothing can be found: a splat of a few kernels, or one in
// which no surface is visible. A room without things has no parts.
Result<RoomParts> find_parts(const GaussianAsset& asset, const PartsOptions& options);

// Lifts label pictures of some views: the label with the largest sum of alpha times transmittance. Kernels
// that no view sees get the label of the nearest seen kernel.
struct LabelPicture {
  Camera camera;
  std::vector<uint16_t> labels;  // rows from the top
};
Result<RoomParts> lift_labels(const GaussianAsset& asset, std::vector<LabelPicture> pictures,
                              const PartsOptions& options);

}  // namespace livegs
