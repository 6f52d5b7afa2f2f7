// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "splat/camera.h"

namespace livegs {

// Lens distortion of OpenCV and of COLMAP's OPENCV model. With x, y the slopes of a ray and r² = x² + y²:
//   x' = x (1 + k1 r² + k2 r⁴) + 2 p1 x y + p2 (r² + 2 x²),   y' = y (…) + p1 (r² + 2 y²) + 2 p2 x y
struct LensDistortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  bool none() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0; }
};

// One photo with its pose. The pictures stay on the disk; picture_store.h reads them.
struct CapturedView {
  std::string name;  // as in the pose file
  std::filesystem::path picture;
  std::filesystem::path mask;   // 8-bit labels of the size of the picture; empty: none
  std::filesystem::path depth;  // 16-bit depth along the view axis, mm; empty: none
  // The pinhole camera without distortion. Its size is that of the pose file and may differ from that of the
  // picture by a factor.
  Camera camera;
  LensDistortion distortion;
  bool held_out = false;  // for scores only, never for training
};

// Photos of one place. World frame and unit of length are those of the pose file.
struct Capture {
  std::filesystem::path folder;
  std::vector<CapturedView> views;             // by name
  std::vector<Eigen::Vector3f> points;         // triangulated surface points; may be empty
  std::vector<Eigen::Vector3f> point_colours;  // of each point, 0..1
  std::vector<std::string> notes;              // about ignored data, one line each
};

// At least this number of photos is needed; two do not determine a surface.
inline constexpr size_t kMinCapturedViews = 3;
// Every eighth view by name is held out if the capture does not name its own (Barron et al. 2022).
inline constexpr size_t kHeldOutInterval = 8;

// Reads the poses of a folder or of one file. In this order:
//   transforms.json (instant-ngp, nerfstudio), transforms_train.json with transforms_test.json
//   a COLMAP model, binary or text, in sparse/0, sparse, colmap/sparse/0 or the folder itself
// transforms.json without ply_file_path uses the points of a COLMAP model in the same folder if the poses are
// equal. Errors are one line: nothing found, a damaged file, missing photos, too few photos.
Result<Capture> read_capture(const std::filesystem::path& path);
// Whether a pose file for read_capture exists.
bool has_poses(const std::filesystem::path& path);

}  // namespace livegs
