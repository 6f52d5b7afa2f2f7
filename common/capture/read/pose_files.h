// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "capture/capture.h"
#include "core/result.h"

// Readers of single pose files. They open photos only for sizes that the file omits.

namespace livegs {

// Largest accepted edge of a picture, px, and coordinate of a pose or point.
inline constexpr double kMaxPictureSide_px = 32768;
inline constexpr double kMaxCaptureCoordinate = 1e6;

// transforms.json of instant-ngp and nerfstudio: OpenGL camera-to-world matrices, intrinsics for all frames
// or for each. `view.picture` is the path of an existing file or, if there is none, the named path.
struct TransformsFile {
  std::vector<CapturedView> views;
  std::filesystem::path points_file;                                // ply_file_path; empty: none
  Eigen::Matrix4d applied_transform = Eigen::Matrix4d::Identity();  // transforms world from COLMAP world
};
Result<TransformsFile> read_transforms_file(const std::filesystem::path& file);
// The text of such a file for a capture, with absolute paths of photos and masks. Points are left out.
std::string transforms_text(const Capture& capture);

// A COLMAP model: cameras, images and points3D, all binary or all text. Other files are ignored.
// Poses are world-to-camera, x right, y down, z forward.
struct ColmapModel {
  std::vector<CapturedView> views;                     // `picture` is empty
  std::vector<Eigen::Vector3f> points, point_colours;  // without those that two photos alone have seen
};
bool has_colmap_model(const std::filesystem::path& folder);
Result<ColmapModel> read_colmap_model(const std::filesystem::path& folder);

// The decoders of COLMAP's binary files, for any bytes. `name` starts the error.
struct ColmapCamera {
  Camera camera;  // intrinsics only
  LensDistortion distortion;
};
using ColmapCameras = std::vector<std::pair<uint32_t, ColmapCamera>>;  // by id
Result<ColmapCameras> decode_colmap_cameras(std::span<const std::byte> bytes, std::string_view name);
Result<std::vector<CapturedView>> decode_colmap_images(std::span<const std::byte> bytes,
                                                       const ColmapCameras& cameras, std::string_view name);
Result<void> decode_colmap_points(std::span<const std::byte> bytes, std::string_view name,
                                  ColmapModel& model);

// x, y, z and optionally red, green, blue of the vertices of a .ply file.
Result<void> read_point_cloud(const std::filesystem::path& file, std::vector<Eigen::Vector3f>& points,
                              std::vector<Eigen::Vector3f>& colours);

}  // namespace livegs
