// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/views/transforms_file.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/file.h"

namespace livegs {
namespace {

constexpr int kMaxPictureEdge_px = 65536;

std::optional<double> number_of(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number()) return {};
  const double value = found->get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

Result<std::vector<NamedCamera>> read_transforms(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto* text = reinterpret_cast<const char*>(bytes->data());
  const nlohmann::json file = nlohmann::json::parse(text, text + bytes->size(), nullptr, false, true);
  if (file.is_discarded())
    return invalid_data(name + ": is not JSON; give the transforms.json of the photos");
  if (!file.is_object() || !file.contains("frames") || !file["frames"].is_array() || file["frames"].empty())
    return invalid_data(name + ": has no frames; give the transforms.json of the photos");
  std::vector<NamedCamera> cameras;
  for (const nlohmann::json& frame : file["frames"]) {
    const std::string which = name + ": frame " + std::to_string(cameras.size());
    if (!frame.is_object()) return invalid_data(which + " is not an object");
    const auto value = [&](const char* key) {
      const auto own = number_of(frame, key);
      return own ? own : number_of(file, key);
    };
    const auto width = value("w"), height = value("h");
    if (!width || !height ||
        !(*width >= 1 && *height >= 1 && *width <= kMaxPictureEdge_px && *height <= kMaxPictureEdge_px))
      return invalid_data(which + " has no picture size w, h from 1 to 65536");
    NamedCamera camera;
    camera.camera.width = static_cast<int>(*width);
    camera.camera.height = static_cast<int>(*height);
    auto focal_x = value("fl_x"), focal_y = value("fl_y");
    if (const auto angle = value("camera_angle_x"); !focal_x && angle)
      focal_x = 0.5 * *width / std::tan(0.5 * *angle);
    if (!focal_x || !(*focal_x > 0))
      return invalid_data(which + " has no focal length fl_x or camera_angle_x");
    if (!focal_y) focal_y = focal_x;
    if (!(*focal_y > 0)) return invalid_data(which + ": fl_y must be above 0");
    camera.camera.focal_x_px = *focal_x;
    camera.camera.focal_y_px = *focal_y;
    camera.camera.centre_x_px = value("cx").value_or(0.5 * *width);
    camera.camera.centre_y_px = value("cy").value_or(0.5 * *height);
    camera.camera.near_m = 0.01;
    Eigen::Matrix4d pose;
    const auto rows = frame.find("transform_matrix");
    bool complete = rows != frame.end() && rows->is_array() && rows->size() >= 3;
    for (size_t r = 0; complete && r < 3; ++r) {
      complete = (*rows)[r].is_array() && (*rows)[r].size() >= 4;
      for (size_t c = 0; complete && c < 4; ++c) {
        complete = (*rows)[r][c].is_number() && std::isfinite((*rows)[r][c].get<double>());
        if (complete)
          pose(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = (*rows)[r][c].get<double>();
      }
    }
    if (!complete) return invalid_data(which + " has no transform_matrix of 4 x 4 numbers");
    Eigen::Matrix3d rotation = pose.topLeftCorner<3, 3>();
    if (!(std::abs(rotation.determinant()) > 1e-9))
      return invalid_data(which + ": transform_matrix is singular");
    for (int c = 0; c < 3; ++c) rotation.col(c).normalize();
    camera.camera.world_from_camera = {pose.topRightCorner<3, 1>(),
                                       Eigen::Quaterniond(rotation).normalized()};
    if (const auto file_path = frame.find("file_path"); file_path != frame.end() && file_path->is_string())
      camera.name = std::filesystem::path(file_path->get<std::string>()).stem().string();
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

Eigen::Vector3d mean_up(const std::vector<Camera>& cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) sum += camera.world_from_camera.orientation * Eigen::Vector3d::UnitY();
  return sum.norm() > 1e-9 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d::UnitY();
}

}  // namespace livegs
