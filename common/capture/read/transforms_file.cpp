// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/picture/picture_file.h"
#include "capture/read/pose_files.h"
#include "core/file.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

using Json = nlohmann::json;

// Largest deviation of RᵀR from the identity. Files hold at least four digits.
constexpr double kMaxRotationError = 1e-2;

// Reads the members of transforms.json. The first problem is kept; later reads return empty values.
class TransformsReader {
 public:
  explicit TransformsReader(const std::filesystem::path& file)
      : name_(file.filename().string()), folder_(file.parent_path()) {}

  const std::optional<Error>& error() const { return error_; }
  void fail(const std::string& problem) {
    if (!error_) error_ = invalid_data(name_ + ": " + problem);
  }

  // A number of the frame or, if it has none, of the file.
  std::optional<double> number(const Json& frame, const Json& file, const char* key) {
    for (const Json* object : {&frame, &file}) {
      const auto found = object->find(key);
      if (found == object->end() || found->is_null()) continue;
      if (!found->is_number() || !std::isfinite(found->get<double>())) {
        fail(std::string(key) + " must be a number");
        return std::nullopt;
      }
      return found->get<double>();
    }
    return std::nullopt;
  }

  std::string text(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || found->is_null()) return "";
    if (!found->is_string()) {
      fail(std::string(key) + " must be a text");
      return "";
    }
    return found->get<std::string>();
  }

  // Three or four rows of four numbers.
  Eigen::Matrix4d matrix(const Json& object, const char* key) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    const auto found = object.find(key);
    const bool rows =
        found != object.end() && found->is_array() && (found->size() == 3 || found->size() == 4);
    bool good = rows;
    for (size_t row = 0; rows && row < found->size(); ++row) {
      const Json& numbers = (*found)[row];
      good = good && numbers.is_array() && numbers.size() == 4;
      for (size_t column = 0; good && column < 4; ++column) {
        good = numbers[column].is_number();
        if (good) matrix(static_cast<int>(row), static_cast<int>(column)) = numbers[column].get<double>();
      }
    }
    if (!good || !(matrix.cwiseAbs().maxCoeff() <= kMaxCaptureCoordinate))
      fail(std::string(key) + " must be a matrix of 4 x 4 numbers up to 1e6");
    return matrix;
  }

  // The named file, with one of the usual endings if it has none.
  std::filesystem::path picture_path(const std::string& name) const {
    std::filesystem::path path = folder_ / name;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) return path;
    for (const char* ending : {".png", ".jpg", ".jpeg", ".JPG", ".JPEG", ".PNG"}) {
      std::filesystem::path with = path;
      with += ending;
      if (std::filesystem::is_regular_file(with, ignored)) return with;
    }
    return path;
  }
  std::filesystem::path beside(const std::string& name) const {
    return name.empty() ? std::filesystem::path() : folder_ / name;
  }

 private:
  std::string name_;
  std::filesystem::path folder_;
  std::optional<Error> error_;
};

Pose pose_of_matrix(const Eigen::Matrix4d& matrix, TransformsReader& reader) {
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double error = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kMaxRotationError) || !(rotation.determinant() > 0))
    reader.fail("transform_matrix is not a rotation with a position; remove scale and mirroring");
  return {matrix.topRightCorner<3, 1>(), Eigen::Quaterniond(rotation).normalized()};
}

// Intrinsics of one frame. Sizes that the file leaves out are those of the picture.
void read_intrinsics(const Json& frame, const Json& file, TransformsReader& reader, CapturedView& view) {
  auto width = reader.number(frame, file, "w"), height = reader.number(frame, file, "h");
  if (!width || !height) {
    const auto size = read_picture_header(view.picture);
    if (!size) return reader.fail("w and h are missing, and " + size.error().message);
    width = size->width;
    height = size->height;
  }
  if (!(*width >= 1 && *width <= kMaxPictureSide_px && *height >= 1 && *height <= kMaxPictureSide_px))
    return reader.fail("w and h must be numbers from 1 to 32768");
  Camera& camera = view.camera;
  camera.width = static_cast<int>(*width);
  camera.height = static_cast<int>(*height);
  auto focal_x = reader.number(frame, file, "fl_x"), focal_y = reader.number(frame, file, "fl_y");
  if (const auto angle = reader.number(frame, file, "camera_angle_x"); angle && !focal_x)
    focal_x = 0.5 * *width / std::tan(0.5 * *angle);
  if (const auto angle = reader.number(frame, file, "camera_angle_y"); angle && !focal_y)
    focal_y = 0.5 * *height / std::tan(0.5 * *angle);
  if (!focal_x && !focal_y) return reader.fail("has neither fl_x nor camera_angle_x");
  camera.focal_x_px = focal_x ? *focal_x : *focal_y;
  camera.focal_y_px = focal_y ? *focal_y : *focal_x;
  camera.centre_x_px = reader.number(frame, file, "cx").value_or(0.5 * *width);
  camera.centre_y_px = reader.number(frame, file, "cy").value_or(0.5 * *height);
  if (!(camera.focal_x_px > 0 && camera.focal_y_px > 0 && camera.focal_x_px < 1e7 && camera.focal_y_px < 1e7))
    reader.fail("fl_x and fl_y must be above 0");
  view.distortion = {
      reader.number(frame, file, "k1").value_or(0), reader.number(frame, file, "k2").value_or(0),
      reader.number(frame, file, "p1").value_or(0), reader.number(frame, file, "p2").value_or(0)};
  if (reader.number(frame, file, "k3").value_or(0) != 0 || reader.number(frame, file, "k4").value_or(0) != 0)
    reader.fail("k3 and k4 are not supported; undistort the photos first");
}

}  // namespace

Result<TransformsFile> read_transforms_file(const std::filesystem::path& file) {
  const auto text = read_text_file(file, 256 << 20);
  if (!text) return text.error();
  const std::string name = file.filename().string();
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object()) return invalid_data(name + ": is not a JSON object");
  TransformsReader reader(file);
  TransformsFile result;
  const std::string model = reader.text(json, "camera_model");
  if (model.find("FISHEYE") != std::string::npos || model == "EQUIRECTANGULAR")
    return unsupported(name + ": camera_model " + model + " is not supported; undistort the photos first");
  result.points_file = reader.beside(reader.text(json, "ply_file_path"));
  if (json.contains("applied_transform")) result.applied_transform = reader.matrix(json, "applied_transform");
  const auto frames = json.find("frames");
  if (frames == json.end() || !frames->is_array()) return invalid_data(name + ": has no list of frames");
  for (size_t i = 0; i < frames->size(); ++i) {
    const Json& frame = (*frames)[i];
    if (!frame.is_object())
      return invalid_data(format_text("%s: frames[%zu] is not an object", name.c_str(), i));
    CapturedView view;
    view.name = reader.text(frame, "file_path");
    if (view.name.empty()) reader.fail(format_text("frames[%zu] has no file_path", i));
    view.picture = reader.picture_path(view.name);
    view.mask = reader.beside(reader.text(frame, "mask_path"));
    view.depth = reader.beside(reader.text(frame, "depth_path"));
    view.camera.world_from_camera = pose_of_matrix(reader.matrix(frame, "transform_matrix"), reader);
    if (!reader.error()) read_intrinsics(frame, json, reader, view);
    if (reader.error()) return *reader.error();
    result.views.push_back(std::move(view));
  }
  if (reader.error()) return *reader.error();
  return result;
}

std::string transforms_text(const Capture& capture) {
  nlohmann::ordered_json file = {{"frames", nlohmann::ordered_json::array()}};
  for (const CapturedView& view : capture.views) {
    const Camera& camera = view.camera;
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = camera.world_from_camera.orientation.toRotationMatrix();
    matrix.topRightCorner<3, 1>() = camera.world_from_camera.position_m;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (int row = 0; row < 4; ++row)
      rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
    nlohmann::ordered_json frame = {{"file_path", std::filesystem::absolute(view.picture).string()},
                                    {"transform_matrix", rows},
                                    {"w", camera.width},
                                    {"h", camera.height},
                                    {"fl_x", camera.focal_x_px},
                                    {"fl_y", camera.focal_y_px},
                                    {"cx", camera.centre_x_px},
                                    {"cy", camera.centre_y_px}};
    if (!view.distortion.none()) {
      frame["k1"] = view.distortion.k1;
      frame["k2"] = view.distortion.k2;
      frame["p1"] = view.distortion.p1;
      frame["p2"] = view.distortion.p2;
    }
    if (!view.mask.empty()) frame["mask_path"] = std::filesystem::absolute(view.mask).string();
    file["frames"].push_back(std::move(frame));
  }
  return file.dump(1) + "\n";
}

}  // namespace livegs
