// SPDX-License-Identifier: Apache-2.0

#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/file.h"
#include "core/written_files.h"
#include "json/json_message.h"
#include "livegs/v1/scene.pb.h"
#include "splat/camera_file.h"

namespace livegs {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

constexpr double kMaxCoordinate_m = 1e6;
constexpr double kMinFov_deg = 1, kMaxFov_deg = 170;
constexpr double kMaxSide_px = 16384;

Result<double> number_of(double number, double low, double high, const std::string& field) {
  if (number >= low && number <= high) return number;
  char range[96];
  std::snprintf(range, sizeof range, ": %g is out of range; use a number from %g to %g", number, low, high);
  return invalid_data(field + range);
}

Result<Eigen::Vector3d> vector_of(const Numbers& numbers, const std::string& field) {
  if (numbers.size() != 3) {
    return invalid_data(field + ": has " + std::to_string(numbers.size()) + " numbers; give 3");
  }
  for (int i = 0; i < 3; ++i) {
    const auto number =
        number_of(numbers[i], -kMaxCoordinate_m, kMaxCoordinate_m, field + "[" + std::to_string(i) + "]");
    if (!number) return number.error();
  }
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

void write_vector(const Eigen::Vector3d& value, Numbers& numbers) {
  for (int i = 0; i < 3; ++i) numbers.Add(value[i]);
}

}  // namespace

Result<Camera> read_camera_file(const std::filesystem::path& path, std::optional<PictureSize> size) {
  auto text = read_text_file(path, 1 << 20);
  if (!text) return text.error();
  const std::string name = path.filename().string();
  v1::CameraFile file;
  if (auto parsed = parse_json_message(*text, file); !parsed)
    return invalid_data(name + ": " + parsed.error().message);
  if (file.position_m().empty() || file.look_at_m().empty()) {
    return invalid_data(name + ": position_m or look_at_m is missing; give both");
  }
  const auto position = vector_of(file.position_m(), name + ": position_m");
  if (!position) return position.error();
  const auto target = vector_of(file.look_at_m(), name + ": look_at_m");
  if (!target) return target.error();
  Result<Eigen::Vector3d> up = Eigen::Vector3d(0, 1, 0);
  if (file.up_size() > 0) up = vector_of(file.up(), name + ": up");
  if (!up) return up.error();
  if ((*target - *position).cross(*up).norm() < 1e-9) {
    return invalid_data(
        name +
        ": up is parallel to the view direction, or look_at_m equals position_m; change up or look_at_m");
  }
  const auto fov_deg = number_of(file.has_vertical_fov_deg() ? file.vertical_fov_deg() : 45.0, kMinFov_deg,
                                 kMaxFov_deg, name + ": vertical_fov_deg");
  if (!fov_deg) return fov_deg.error();
  const PictureSize own{file.has_width() ? file.width() : 640, file.has_height() ? file.height() : 480};
  const PictureSize used = size.value_or(own);
  if (auto width = number_of(used.width, 1, kMaxSide_px, name + ": width"); !width) return width.error();
  if (auto height = number_of(used.height, 1, kMaxSide_px, name + ": height"); !height) return height.error();
  return look_at(*position, *target, *up, *fov_deg * std::numbers::pi / 180.0, used.width, used.height);
}

Result<PictureChoice> picture_choice(const std::filesystem::path& camera_file,
                                     std::optional<PictureSize> size) {
  if (camera_file.empty()) return PictureChoice{std::nullopt, size.value_or(PictureSize{})};
  auto read = read_camera_file(camera_file, size);
  if (!read) return read.error();
  return PictureChoice{*read, {read->width, read->height}};
}

Result<void> write_camera_file(const std::filesystem::path& path, const Camera& camera) {
  const Pose& pose = camera.world_from_camera;
  v1::CameraFile file;
  write_vector(pose.position_m, *file.mutable_position_m());
  write_vector(pose * Eigen::Vector3d(0, 0, -1), *file.mutable_look_at_m());
  write_vector(pose.orientation * Eigen::Vector3d::UnitY(), *file.mutable_up());
  file.set_vertical_fov_deg(2 * std::atan(0.5 * camera.height / camera.focal_y_px) * 180.0 /
                            std::numbers::pi);
  file.set_width(camera.width);
  file.set_height(camera.height);
  google::protobuf::util::JsonPrintOptions print;
  print.preserve_proto_field_names = true;
  print.add_whitespace = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(file, &text, print).ok()) {
    return Error{ErrorCode::Internal, path.string() + ": the camera cannot be converted to JSON"};
  }
  auto written = write_file_atomically(path, text);
  if (written) note_written(path);
  return written;
}

}  // namespace livegs
