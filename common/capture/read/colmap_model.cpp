// SPDX-License-Identifier: Apache-2.0
// COLMAP's model files, https://colmap.github.io/format.html. Numbers of a text file have the order of the
// binary file, so both fill the same rows.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "capture/read/pose_files.h"
#include "core/file.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

// Camera models by number. `shape` gives the meaning of the parameters: f one focal length, x and y two,
// c the principal point, 1 and 2 radial terms, p two tangential terms. Empty: not supported.
struct CameraModel {
  const char* name;
  size_t parameters;
  const char* shape;
};
constexpr CameraModel kCameraModels[] = {{"SIMPLE_PINHOLE", 3, "fc"},      {"PINHOLE", 4, "xyc"},
                                         {"SIMPLE_RADIAL", 4, "fc1"},      {"RADIAL", 5, "fc12"},
                                         {"OPENCV", 8, "xyc12p"},          {"OPENCV_FISHEYE", 8, ""},
                                         {"FULL_OPENCV", 12, ""},          {"FOV", 5, ""},
                                         {"SIMPLE_RADIAL_FISHEYE", 4, ""}, {"RADIAL_FISHEYE", 5, ""},
                                         {"THIN_PRISM_FISHEYE", 12, ""}};

Result<ColmapCamera> camera_of(const CameraModel& model, double width, double height,
                               std::span<const double> parameters, std::string_view name) {
  const std::string prefix(name);
  if (model.shape[0] == '\0') {
    return unsupported(prefix + ": camera model " + model.name +
                       " is not supported; run colmap image_undistorter first");
  }
  if (!(width >= 1 && width <= kMaxPictureSide_px && height >= 1 && height <= kMaxPictureSide_px))
    return invalid_data(prefix + ": width and height of a camera must be from 1 to 32768");
  ColmapCamera result;
  result.camera.width = static_cast<int>(width);
  result.camera.height = static_cast<int>(height);
  size_t at = 0;
  for (const char* part = model.shape; *part; ++part) {
    switch (*part) {
      case 'f':
        result.camera.focal_x_px = result.camera.focal_y_px = parameters[at++];
        break;
      case 'x':
        result.camera.focal_x_px = parameters[at++];
        break;
      case 'y':
        result.camera.focal_y_px = parameters[at++];
        break;
      case 'c':
        result.camera.centre_x_px = parameters[at++];
        result.camera.centre_y_px = parameters[at++];
        break;
      case '1':
        result.distortion.k1 = parameters[at++];
        break;
      case '2':
        result.distortion.k2 = parameters[at++];
        break;
      default:
        result.distortion.p1 = parameters[at++];
        result.distortion.p2 = parameters[at++];
    }
  }
  for (double parameter : parameters) {
    if (!(std::abs(parameter) < 1e7)) return invalid_data(prefix + ": a camera has a number over 1e7");
  }
  if (!(result.camera.focal_x_px > 0 && result.camera.focal_y_px > 0))
    return invalid_data(prefix + ": focal lengths must be above 0");
  return result;
}

// `numbers`: quaternion w x y z and translation, world to camera.
Result<CapturedView> view_of(std::span<const double, 7> numbers, uint32_t camera_id,
                             const ColmapCameras& cameras, std::string view_name, std::string_view name) {
  const auto found = std::lower_bound(cameras.begin(), cameras.end(), camera_id,
                                      [](const auto& camera, uint32_t id) { return camera.first < id; });
  if (found == cameras.end() || found->first != camera_id) {
    return invalid_data(format_text("%s: photo \"%.200s\" has camera %u, which does not exist",
                                    std::string(name).c_str(), view_name.c_str(), camera_id));
  }
  const Eigen::Quaterniond turn(numbers[0], numbers[1], numbers[2], numbers[3]);
  const Eigen::Vector3d shift(numbers[4], numbers[5], numbers[6]);
  if (!(std::abs(turn.norm() - 1) < 0.1) || !(shift.cwiseAbs().maxCoeff() <= kMaxCaptureCoordinate))
    return invalid_data(std::string(name) + ": the pose of \"" + view_name.substr(0, 200) +
                        "\" is not valid");
  CapturedView view;
  view.name = std::move(view_name);
  view.camera = found->second.camera;
  view.distortion = found->second.distortion;
  const Eigen::Quaterniond world_from_image = turn.normalized().conjugate();
  // Half a turn about x: COLMAP's y is down and its z forward.
  view.camera.world_from_camera.orientation = world_from_image * Eigen::Quaterniond(0, 1, 0, 0);
  view.camera.world_from_camera.position_m = world_from_image * -shift;
  return view;
}

void sort_cameras(ColmapCameras& cameras) {
  std::sort(cameras.begin(), cameras.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
}

void add_point(const Eigen::Vector3d& point, double red, double green, double blue, ColmapModel& model) {
  if (!(point.cwiseAbs().maxCoeff() <= kMaxCaptureCoordinate)) return;
  model.points.push_back(point.cast<float>());
  model.point_colours.push_back(
      (Eigen::Vector3d(red, green, blue) / 255.0).cast<float>().cwiseMax(0.0f).cwiseMin(1.0f));
}

// Little-endian values. After the first read over the end, all are 0 and `good` is false.
class BinaryReader {
 public:
  explicit BinaryReader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <class T>
  T next() {
    T value{};
    if (left_.size() < sizeof(T)) {
      fail();
      return value;
    }
    std::memcpy(&value, left_.data(), sizeof(T));
    left_ = left_.subspan(sizeof(T));
    return value;
  }
  std::string next_name() {
    const auto* first = reinterpret_cast<const char*>(left_.data());
    const size_t length = left_.empty() ? 0 : strnlen(first, left_.size());
    if (length == left_.size()) {
      fail();
      return "";
    }
    std::string name(first, length);
    left_ = left_.subspan(length + 1);
    return name;
  }
  // Skips `count` rows of `row_bytes`.
  void skip(uint64_t count, size_t row_bytes) {
    if (count > left_.size() / row_bytes) return fail();
    left_ = left_.subspan(count * row_bytes);
  }
  // A count of rows that have at least `row_bytes` each, so that memory for them is bounded by the file.
  uint64_t count(size_t row_bytes) {
    const auto count = next<uint64_t>();
    if (count > left_.size() / row_bytes) fail();
    return good_ ? count : 0;
  }
  bool good() const { return good_; }
  bool at_end() const { return left_.empty(); }

 private:
  void fail() {
    good_ = false;
    left_ = {};
  }
  std::span<const std::byte> left_;
  bool good_ = true;
};

Error damaged(std::string_view name) {
  return invalid_data(std::string(name) + ": counts do not match the size; export the model again");
}

// Lines of a text file, without comments.
class TextLines {
 public:
  explicit TextLines(std::string_view text) : left_(text) {}
  bool next(std::string_view& line) {
    while (!left_.empty()) {
      const size_t end = std::min(left_.find('\n'), left_.size());
      line = left_.substr(0, end);
      left_.remove_prefix(std::min(end + 1, left_.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (!line.starts_with('#')) return true;
    }
    return false;
  }
  // The next line without taking it.
  bool peek(std::string_view& line) const { return TextLines(*this).next(line); }

 private:
  std::string_view left_;
};

std::string_view next_word(std::string_view& line) {
  const size_t first = std::min(line.find_first_not_of(" \t"), line.size());
  line.remove_prefix(first);
  const size_t end = std::min(line.find_first_of(" \t"), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end);
  return word;
}

bool next_number(std::string_view& line, double& value) {
  const std::string_view word = next_word(line);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

// A line of 2D points: numbers, three of each point. It may be empty.
bool is_points_line(std::string_view line) {
  size_t numbers = 0;
  for (double value = 0; line.find_first_not_of(" \t") != line.npos; ++numbers) {
    if (!next_number(line, value)) return false;
  }
  return numbers % 3 == 0;
}

bool is_id(double value) { return value >= 0 && value < 4294967296.0 && value == std::floor(value); }

Result<ColmapCameras> parse_cameras(std::string_view text, std::string_view name) {
  ColmapCameras cameras;
  TextLines lines(text);
  for (std::string_view line; lines.next(line);) {
    if (is_points_line(line) && line.find_first_not_of(" \t") == line.npos) continue;
    double id = 0, width = 0, height = 0;
    bool good = next_number(line, id) && is_id(id);
    const std::string_view model_name = next_word(line);
    good = good && next_number(line, width) && next_number(line, height);
    std::vector<double> parameters;
    for (double value = 0; good && parameters.size() < 16 && line.find_first_not_of(" \t") != line.npos;) {
      good = next_number(line, value);
      parameters.push_back(value);
    }
    const auto* model = std::find_if(std::begin(kCameraModels), std::end(kCameraModels),
                                     [&](const CameraModel& one) { return one.name == model_name; });
    if (!good || model == std::end(kCameraModels) || parameters.size() != model->parameters) {
      return invalid_data(std::string(name) +
                          ": a camera is not ID MODEL WIDTH HEIGHT and the parameters of a known model");
    }
    auto camera = camera_of(*model, width, height, parameters, name);
    if (!camera) return camera.error();
    cameras.push_back({static_cast<uint32_t>(id), *camera});
  }
  sort_cameras(cameras);
  return cameras;
}

Result<std::vector<CapturedView>> parse_images(std::string_view text, const ColmapCameras& cameras,
                                               std::string_view name) {
  std::vector<CapturedView> views;
  TextLines lines(text);
  for (std::string_view line; lines.next(line);) {
    if (line.find_first_not_of(" \t") == line.npos) continue;
    double id = 0, camera_id = 0, numbers[7] = {};
    bool good = next_number(line, id);
    for (double& number : numbers) good = good && next_number(line, number);
    good = good && next_number(line, camera_id) && is_id(camera_id);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    while (line.ends_with(' ') || line.ends_with('\t')) line.remove_suffix(1);
    if (!good || line.empty())
      return invalid_data(std::string(name) + ": a photo is not ID QW QX QY QZ TX TY TZ CAMERA NAME");
    auto view = view_of(numbers, static_cast<uint32_t>(camera_id), cameras, std::string(line), name);
    if (!view) return view.error();
    views.push_back(std::move(*view));
    // The second line of a photo has its 2D points. Some writers omit it.
    if (std::string_view following; lines.peek(following) && is_points_line(following)) lines.next(following);
  }
  return views;
}

// Two photos always agree about a point, so that only a third one shows a wrong match. Models without tracks
// do not state the photos.
bool is_confirmed(uint64_t photos) { return photos == 0 || photos >= 3; }

Result<void> parse_points(std::string_view text, std::string_view name, ColmapModel& model) {
  TextLines lines(text);
  for (std::string_view line; lines.next(line);) {
    if (line.find_first_not_of(" \t") == line.npos) continue;
    double numbers[7] = {};  // id, position, colour
    for (double& number : numbers) {
      if (!next_number(line, number))
        return invalid_data(std::string(name) + ": a point is not ID X Y Z R G B …");
    }
    double number = 0;
    uint64_t pairs = 0;  // of a photo and a feature, after the reprojection error
    if (next_number(line, number))
      while (next_number(line, number) && next_number(line, number)) ++pairs;
    if (is_confirmed(pairs))
      add_point({numbers[1], numbers[2], numbers[3]}, numbers[4], numbers[5], numbers[6], model);
  }
  return {};
}

std::filesystem::path model_file(const std::filesystem::path& folder, const char* stem, bool binary) {
  return folder / (std::string(stem) + (binary ? ".bin" : ".txt"));
}

bool is_complete(const std::filesystem::path& folder, bool binary) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(model_file(folder, "cameras", binary), ignored) &&
         std::filesystem::is_regular_file(model_file(folder, "images", binary), ignored);
}

Result<ColmapModel> read_binary(const std::filesystem::path& folder) {
  ColmapModel model;
  const auto cameras_file = read_file(model_file(folder, "cameras", true), 1 << 30);
  if (!cameras_file) return cameras_file.error();
  const auto cameras = decode_colmap_cameras(*cameras_file, "cameras.bin");
  if (!cameras) return cameras.error();
  const auto images_file = read_file(model_file(folder, "images", true));
  if (!images_file) return images_file.error();
  auto views = decode_colmap_images(*images_file, *cameras, "images.bin");
  if (!views) return views.error();
  model.views = std::move(*views);
  const std::filesystem::path points = model_file(folder, "points3D", true);
  if (!std::filesystem::exists(points)) return model;
  const auto points_file = read_file(points);
  if (!points_file) return points_file.error();
  if (auto read = decode_colmap_points(*points_file, "points3D.bin", model); !read) return read.error();
  return model;
}

Result<ColmapModel> read_text(const std::filesystem::path& folder) {
  constexpr uint64_t kMaxTextBytes = uint64_t{2} << 30;
  ColmapModel model;
  const auto cameras_file = read_text_file(model_file(folder, "cameras", false));
  if (!cameras_file) return cameras_file.error();
  const auto cameras = parse_cameras(*cameras_file, "cameras.txt");
  if (!cameras) return cameras.error();
  const auto images_file = read_text_file(model_file(folder, "images", false), kMaxTextBytes);
  if (!images_file) return images_file.error();
  auto views = parse_images(*images_file, *cameras, "images.txt");
  if (!views) return views.error();
  model.views = std::move(*views);
  const std::filesystem::path points = model_file(folder, "points3D", false);
  if (!std::filesystem::exists(points)) return model;
  const auto points_file = read_text_file(points, kMaxTextBytes);
  if (!points_file) return points_file.error();
  if (auto read = parse_points(*points_file, "points3D.txt", model); !read) return read.error();
  return model;
}

}  // namespace

Result<ColmapCameras> decode_colmap_cameras(std::span<const std::byte> bytes, std::string_view name) {
  BinaryReader reader(bytes);
  ColmapCameras cameras;
  const uint64_t count = reader.count(24 + 3 * 8);
  for (uint64_t i = 0; i < count; ++i) {
    const auto id = reader.next<uint32_t>();
    const auto model = reader.next<int32_t>();
    const auto width = reader.next<uint64_t>(), height = reader.next<uint64_t>();
    if (!reader.good()) break;
    if (model < 0 || model >= static_cast<int32_t>(std::size(kCameraModels)))
      return unsupported(
          format_text("%s: camera model %d is not supported; run colmap image_undistorter first",
                      std::string(name).c_str(), model));
    double parameters[12] = {};
    for (size_t k = 0; k < kCameraModels[model].parameters; ++k) parameters[k] = reader.next<double>();
    if (!reader.good()) break;
    auto camera = camera_of(kCameraModels[model], static_cast<double>(width), static_cast<double>(height),
                            std::span(parameters, kCameraModels[model].parameters), name);
    if (!camera) return camera.error();
    cameras.push_back({id, *camera});
  }
  if (!reader.good() || !reader.at_end()) return damaged(name);
  sort_cameras(cameras);
  return cameras;
}

Result<std::vector<CapturedView>> decode_colmap_images(std::span<const std::byte> bytes,
                                                       const ColmapCameras& cameras, std::string_view name) {
  BinaryReader reader(bytes);
  std::vector<CapturedView> views;
  const uint64_t count = reader.count(4 + 7 * 8 + 4 + 1 + 8);
  for (uint64_t i = 0; i < count; ++i) {
    reader.next<uint32_t>();  // id
    double numbers[7];
    for (double& number : numbers) number = reader.next<double>();
    const auto camera_id = reader.next<uint32_t>();
    std::string view_name = reader.next_name();
    reader.skip(reader.next<uint64_t>(), 8 + 8 + 8);
    if (!reader.good()) break;
    auto view = view_of(numbers, camera_id, cameras, std::move(view_name), name);
    if (!view) return view.error();
    views.push_back(std::move(*view));
  }
  if (!reader.good() || !reader.at_end()) return damaged(name);
  return views;
}

Result<void> decode_colmap_points(std::span<const std::byte> bytes, std::string_view name,
                                  ColmapModel& model) {
  BinaryReader reader(bytes);
  const uint64_t count = reader.count(8 + 3 * 8 + 3 + 8 + 8);
  for (uint64_t i = 0; i < count; ++i) {
    reader.next<uint64_t>();  // id
    const double x = reader.next<double>(), y = reader.next<double>(), z = reader.next<double>();
    const auto red = reader.next<uint8_t>(), green = reader.next<uint8_t>(), blue = reader.next<uint8_t>();
    reader.next<double>();  // reprojection error
    const auto photos = reader.next<uint64_t>();
    reader.skip(photos, 4 + 4);
    if (!reader.good()) break;
    if (is_confirmed(photos)) add_point({x, y, z}, red, green, blue, model);
  }
  if (!reader.good() || !reader.at_end()) return damaged(name);
  return {};
}

bool has_colmap_model(const std::filesystem::path& folder) {
  return is_complete(folder, true) || is_complete(folder, false);
}

Result<ColmapModel> read_colmap_model(const std::filesystem::path& folder) {
  return is_complete(folder, true) ? read_binary(folder) : read_text(folder);
}

}  // namespace livegs
