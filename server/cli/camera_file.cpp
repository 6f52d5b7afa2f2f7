// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/camera_file.h"

#include <google/protobuf/util/json_util.h>

#include <numbers>

#include "core/file.h"
#include "livegs/v1/scene.pb.h"
#include "scene/values/scene_values.h"

namespace livegs {

Result<Camera> read_camera_file(const std::filesystem::path& path) {
  auto text = read_text_file(path, 1 << 20);
  if (!text) return text.error();
  const std::string name = path.filename().string();
  v1::CameraFile file;
  const auto status = google::protobuf::util::JsonStringToMessage(*text, &file);
  if (!status.ok()) {
    return invalid_data(name + ": " + std::string(status.message()) +
                        " (field names are those of CameraFile in proto/livegs/v1/scene.proto)");
  }
  const auto fail = [&](const Error& error) { return Error{error.code, name + ": " + error.message}; };
  if (file.position_m().empty() || file.look_at_m().empty()) {
    return invalid_data(name + ": position_m and look_at_m are needed");
  }
  auto position = vector_value(file.position_m(), Eigen::Vector3d::Zero(), "position_m");
  if (!position) return fail(position.error());
  auto target = vector_value(file.look_at_m(), Eigen::Vector3d::Zero(), "look_at_m");
  if (!target) return fail(target.error());
  auto up = vector_value(file.up(), Eigen::Vector3d::UnitY(), "up");
  if (!up) return fail(up.error());
  if ((*target - *position).cross(*up).norm() < 1e-9) {
    return invalid_data(name + ": up is along the view direction, or look_at_m is position_m");
  }
  auto fov =
      number_value(file.has_vertical_fov_deg() ? file.vertical_fov_deg() : 45.0, 1, 170, "vertical_fov_deg");
  if (!fov) return fail(fov.error());
  auto width = number_value(file.has_width() ? file.width() : 640, 1, 16384, "width");
  if (!width) return fail(width.error());
  auto height = number_value(file.has_height() ? file.height() : 480, 1, 16384, "height");
  if (!height) return fail(height.error());
  return look_at(*position, *target, *up, *fov * std::numbers::pi / 180.0, static_cast<int>(*width),
                 static_cast<int>(*height));
}

}  // namespace livegs
