// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "capture/capture.h"
#include "capture/read/pose_files.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// Two pose files agree if cameras of one name differ by less than this share of the cameras' spread, and by
// this angle, rad. Files hold at least four digits.
constexpr double kMaxPoseDifference = 1e-3;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// The folder of a COLMAP model at or below `folder`; empty: none.
fs::path colmap_folder(const fs::path& folder) {
  for (const char* place : {"sparse/0", "sparse", "colmap/sparse/0", ""}) {
    if (has_colmap_model(folder / place)) return folder / place;
  }
  return {};
}

// COLMAP's names are relative to the picture folder, which the model does not name.
fs::path find_picture(const fs::path& root, const std::string& name) {
  for (const char* place : {"images", "", "input", "photos", "rgb"}) {
    if (is_file(root / place / name)) return root / place / name;
  }
  return root / "images" / name;
}

// Labels of the picture: masks/NAME.png, with or without the ending of the picture.
fs::path find_mask(const fs::path& root, const std::string& name) {
  const fs::path whole = root / "masks" / (name + ".png");
  if (is_file(whole)) return whole;
  const fs::path bare = (root / "masks" / name).replace_extension(".png");
  return is_file(bare) ? bare : fs::path();
}

std::string base_name(const CapturedView& view) { return fs::path(view.name).filename().string(); }

void hold_out(Capture& capture, const std::set<std::string>& names) {
  for (size_t i = 0; i < capture.views.size(); ++i) {
    CapturedView& view = capture.views[i];
    view.held_out = names.empty() ? i % kHeldOutInterval == kHeldOutInterval - 1 : names.contains(view.name);
  }
}

// Points of a COLMAP model, moved into the world of the capture; left out if the poses do not agree.
void take_colmap_points(const fs::path& folder, const Eigen::Matrix4d& world_from_colmap, Capture& capture) {
  const fs::path place = colmap_folder(folder);
  if (place.empty()) return;
  auto model = read_colmap_model(place);
  if (!model) {
    capture.notes.push_back("points of the COLMAP model are not used: " + model.error().message);
    return;
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const CapturedView& view : capture.views) middle += view.camera.world_from_camera.position_m;
  middle /= static_cast<double>(capture.views.size());
  double spread = 0;
  for (const CapturedView& view : capture.views)
    spread += (view.camera.world_from_camera.position_m - middle).norm();
  spread /= static_cast<double>(capture.views.size());
  const Eigen::Matrix3d turn = world_from_colmap.topLeftCorner<3, 3>();
  const Eigen::Vector3d shift = world_from_colmap.topRightCorner<3, 1>();
  size_t shared = 0, same = 0;
  for (const CapturedView& view : capture.views) {
    for (const CapturedView& other : model->views) {
      if (base_name(other) != base_name(view)) continue;
      const Pose &a = view.camera.world_from_camera, &b = other.camera.world_from_camera;
      ++shared;
      same += (a.position_m - (turn * b.position_m + shift)).norm() < kMaxPoseDifference * spread &&
              (a.orientation.toRotationMatrix() - turn * b.orientation.toRotationMatrix()).norm() <
                  2 * kMaxPoseDifference;
      break;
    }
  }
  if (shared == 0 || same < shared) {
    capture.notes.push_back(
        format_text("points of the COLMAP model are not used: its poses differ in %zu of %zu photos",
                    shared - same, shared));
    return;
  }
  capture.points = std::move(model->points);
  capture.point_colours = std::move(model->point_colours);
  for (Eigen::Vector3f& point : capture.points) point = (turn * point.cast<double>() + shift).cast<float>();
}

Result<Capture> capture_of_transforms(const fs::path& file) {
  auto read = read_transforms_file(file);
  if (!read) return read.error();
  Capture capture;
  capture.folder = file.parent_path();
  capture.views = std::move(read->views);
  std::set<std::string> held_out;
  const fs::path test = capture.folder / "transforms_test.json";
  if (file.filename() != test.filename() && is_file(test)) {
    auto tests = read_transforms_file(test);
    if (!tests) return tests.error();
    for (CapturedView& view : tests->views) {
      held_out.insert(view.name);
      const bool known = std::any_of(capture.views.begin(), capture.views.end(),
                                     [&](const CapturedView& one) { return one.name == view.name; });
      if (!known) capture.views.push_back(std::move(view));
    }
  }
  std::sort(capture.views.begin(), capture.views.end(),
            [](const CapturedView& a, const CapturedView& b) { return a.name < b.name; });
  hold_out(capture, held_out);
  if (!read->points_file.empty() && is_file(read->points_file)) {
    if (auto points = read_point_cloud(read->points_file, capture.points, capture.point_colours); !points)
      return points.error();
  } else if (!capture.views.empty()) {
    if (!read->points_file.empty())
      capture.notes.push_back("ply_file_path " + read->points_file.string() + " does not exist");
    take_colmap_points(capture.folder, read->applied_transform, capture);
  }
  return capture;
}

Result<Capture> capture_of_colmap(const fs::path& model_folder, const fs::path& root) {
  auto model = read_colmap_model(model_folder);
  if (!model) return model.error();
  Capture capture;
  capture.folder = root;
  capture.views = std::move(model->views);
  capture.points = std::move(model->points);
  capture.point_colours = std::move(model->point_colours);
  for (CapturedView& view : capture.views) {
    view.picture = find_picture(root, view.name);
    view.mask = find_mask(root, view.name);
  }
  std::sort(capture.views.begin(), capture.views.end(),
            [](const CapturedView& a, const CapturedView& b) { return a.name < b.name; });
  hold_out(capture, {});
  return capture;
}

// Leaves out views without a picture and points that are not finite. Too few views are an error.
Result<Capture> check_views(Capture capture, const fs::path& path) {
  const size_t named = capture.views.size();
  std::string missing;
  std::erase_if(capture.views, [&](const CapturedView& view) {
    if (is_file(view.picture)) return false;
    if (missing.empty()) missing = view.picture.string();
    return true;
  });
  const size_t found = capture.views.size();
  if (named > 0 && found == 0)
    return not_found(path.string() + ": none of the " + std::to_string(named) +
                     " photos exists; the first is " + missing + "; copy the photos next to the poses");
  if (found < kMinCapturedViews) {
    return invalid_data(format_text("%s: has %zu photos with poses, fewer than %zu; take more photos",
                                    path.c_str(), found, kMinCapturedViews));
  }
  if (found < named) {
    capture.notes.push_back(format_text("%zu of %zu photos do not exist; the first is %s", named - found,
                                        named, missing.c_str()));
  }
  size_t kept = 0;
  for (size_t i = 0; i < capture.points.size(); ++i) {
    if (!(capture.points[i].cwiseAbs().maxCoeff() <= static_cast<float>(kMaxCaptureCoordinate))) continue;
    capture.points[kept] = capture.points[i];
    capture.point_colours[kept++] = capture.point_colours[i];
  }
  capture.points.resize(kept);
  capture.point_colours.resize(kept);
  return capture;
}

Result<Capture> checked(Result<Capture> capture, const fs::path& path) {
  if (capture) return check_views(std::move(*capture), path);
  if (capture.error().code != ErrorCode::InvalidData) return capture;
  return with_remedy(capture.error(), "write the file again with the program that placed the photos");
}

}  // namespace

bool has_poses(const fs::path& path) {
  return is_file(path) || is_file(path / "transforms.json") || is_file(path / "transforms_train.json") ||
         !colmap_folder(path).empty();
}

Result<Capture> read_capture(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    return not_found(path.string() + ": no such file or folder; check the path");
  if (!fs::is_directory(path, ignored)) return checked(capture_of_transforms(path), path);
  for (const char* name : {"transforms.json", "transforms_train.json"}) {
    if (is_file(path / name)) return checked(capture_of_transforms(path / name), path);
  }
  if (const fs::path model = colmap_folder(path); !model.empty())
    return checked(capture_of_colmap(model, path), path);
  return not_found(path.string() + ": has no poses; add transforms.json or a COLMAP model in sparse/0");
}

}  // namespace livegs
