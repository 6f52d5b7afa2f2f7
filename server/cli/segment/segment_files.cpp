// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/segment/segment_files.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/math/rotation_between.h"
#include "core/written_files.h"
#include "gaussian/asset_file.h"
#include "gaussian/transform_asset.h"
#include "parts/room_solids.h"
#include "parts/views/choose_cameras.h"
#include "parts/views/room_view.h"
#include "scene/values/scene_values.h"
#include "splat/frame_bounds.h"
#include "splat/image.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr double kLevelTilt_deg = 0.2;  // a floor within this of level is not turned
constexpr int kPictureWidth_px = 640;
constexpr float kDimmed = 0.35f;  // of the room around the outlined thing

ordered_json numbers(const Eigen::Vector3d& v) {
  const auto rounded = [](double x) { return std::round(x * 1e6) / 1e6 + 0.0; };
  return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}

// Planes and boxes of a room in the world of the scene.
ordered_json colliders(const SegmentedRoom& room, const Eigen::Quaterniond& world_from_asset) {
  ordered_json all = ordered_json::array();
  for (const RoomSolid& solid : room_solids(room.parts, room.up)) {
    const ordered_json at = numbers(room.scale * (world_from_asset * solid.point_m));
    ordered_json collider;
    if (solid.size_m) {
      const Eigen::Quaterniond q = (world_from_asset * Eigen::Quaterniond(solid.axes)).normalized();
      collider["box"] = {{"size_m", numbers(room.scale * *solid.size_m)}};
      collider["pose"] = {{"position_m", at}, {"orientation", {q.w(), q.x(), q.y(), q.z()}}};
    } else {
      collider["plane"] = {{"point_m", at}, {"normal", numbers(world_from_asset * solid.normal)}};
    }
    collider["friction"] = 0.5;
    collider["restitution"] = 0.2;
    all.push_back(std::move(collider));
  }
  return all;
}

std::string scene_text(const SegmentedRoom& room, const Eigen::Quaterniond& world_from_asset) {
  ordered_json scene;
  scene["environment"] = {{"asset", "room.ply"},
                          {"scale", room.scale},
                          {"up", room.up_axis},
                          {"colliders", colliders(room, world_from_asset)}};
  scene["objects"] = ordered_json::array();
  for (const SegmentedThing& thing : room.things) {
    ordered_json object = {
        {"name", thing.name}, {"asset", thing.name + ".ply"}, {"scale", room.scale}, {"up", room.up_axis}};
    if (thing.part.support)
      object["standing"] = true;
    else if (thing.part.wall)
      object["physics"] = {{"behavior", "STATIC"}};
    scene["objects"].push_back(std::move(object));
  }
  return scene.dump(2) + "\n";
}

Image draw_assets(std::span<const GaussianAsset* const> assets, const Camera& camera,
                  std::vector<uint32_t>* ids = nullptr) {
  std::vector<PosedKernels> posed;
  std::vector<DrawnObject> objects;
  posed.reserve(assets.size());
  for (size_t i = 0; i < assets.size(); ++i) {
    posed.push_back(pose_in_place(*assets[i]));
    objects.push_back({assets[i], &posed.back(), static_cast<uint32_t>(i)});
  }
  Rasteriser rasteriser;
  RasterisedView view;
  rasteriser.draw(objects, camera, {}, view);
  if (ids) *ids = view.object_id;
  return view.image;
}

// The used view with the most pixels of the label.
const Camera& best_view(const RoomParts& parts, uint16_t label) {
  size_t best = 0, most = 0;
  for (size_t v = 0; v < parts.pictures.size(); ++v) {
    const auto count =
        static_cast<size_t>(std::count(parts.pictures[v].begin(), parts.pictures[v].end(), label));
    if (count > most) most = count, best = v;
  }
  return parts.cameras[best];
}

// Two pictures side by side: the thing at its place in the dimmed room, and the room without it.
Image thing_picture(const SegmentedRoom& room, const SegmentedThing& thing) {
  const Camera camera = with_width(best_view(room.parts, thing.part.label), kPictureWidth_px);
  std::vector<const GaussianAsset*> assets{&thing.asset};
  std::vector<uint32_t> ids;
  for (const SegmentedThing& other : room.things)
    if (&other != &thing) assets.push_back(&other.asset);
  assets.push_back(&room.room);
  Image with = draw_assets(assets, camera, &ids);
  const Image without = draw_assets(std::span(assets).subspan(1), camera);
  Image both;
  both.width = 2 * with.width;
  both.height = with.height;
  both.pixels.resize(2 * with.pixels.size());
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x) {
      const float light = ids[static_cast<size_t>(y) * with.width + x] == 0 ? 1.0f : kDimmed;
      for (int c = 0; c < 4; ++c) {
        both.at(x, y)[c] = c < 3 ? light * with.at(x, y)[c] : 1.0f;
        both.at(with.width + x, y)[c] = c < 3 ? without.at(x, y)[c] : 1.0f;
      }
    }
  return both;
}

std::string page_text(const SegmentedRoom& room) {
  char line[400];
  std::string page = "# Parts of a room\n\n";
  std::snprintf(line, sizeof line,
                "%zu things were found. `livegs-server room.scene.json` runs the scene; the room is its "
                "background.\n\n",
                room.things.size());
  page += line;
  page += "Left: the thing at its place. Right: the room without it.\n\n";
  for (const SegmentedThing& thing : room.things) {
    const Eigen::Vector3d size = room.scale * thing.size;
    std::snprintf(
        line, sizeof line, "## %s\n\n%zu kernels, %.3g x %.3g x %.3g m%s%s%s\n\n![%s](%s.png)\n\n",
        thing.name.c_str(), thing.asset.size(), size.x(), size.y(), size.z(),
        thing.part.support ? ", stands on a support" : "", thing.part.wall ? ", touches a wall" : "",
        thing.unfilled ? "; the background was not filled" : "", thing.name.c_str(), thing.name.c_str());
    page += line;
  }
  page +=
      "`labels.u16` has one little-endian number of 16 bits per kernel of the input: 0 for the room, N for "
      "the Nth thing.\n";
  return page;
}

}  // namespace

Result<void> write_segmented_room(const fs::path& folder, SegmentedRoom room) {
  // Level: the largest support becomes perpendicular to the up axis.
  const auto& supports = room.parts.planes.supports;
  const auto largest =
      std::max_element(supports.begin(), supports.end(),
                       [](const RoomPlane& a, const RoomPlane& b) { return a.share < b.share; });
  Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  if (largest != supports.end()) level = rotation_between(largest->normal, room.up);
  if (Eigen::AngleAxisd(level).angle() * 180 / M_PI > kLevelTilt_deg) {
    for (SegmentedThing& thing : room.things) transform_asset(thing.asset, level, 1.0);
    transform_asset(room.room, level, 1.0);
    transform_asset(room.original, level, 1.0);
    for (Camera& camera : room.parts.cameras)
      camera.world_from_camera = Pose{Eigen::Vector3d::Zero(), level} * camera.world_from_camera;
  } else {
    level.setIdentity();
  }
  const auto world_from_asset = up_value(room.up_axis, "--up");
  if (!world_from_asset) return world_from_asset.error();

  std::error_code error;
  const bool is_new = !fs::exists(folder, error);
  const fs::path scratch = folder / kUnfinishedFolder;
  fs::remove_all(scratch, error);
  fs::create_directories(scratch, error);
  if (error) return file_error(scratch, "cannot be created", error);
  const auto write_all = [&]() -> Result<void> {
    for (const SegmentedThing& thing : room.things) {
      if (auto written = write_asset(scratch / (thing.name + ".ply"), thing.asset); !written) return written;
      if (auto written = write_png(scratch / (thing.name + ".png"), thing_picture(room, thing)); !written)
        return written;
    }
    if (auto written = write_asset(scratch / "room.ply", room.room); !written) return written;
    if (auto written =
            write_file_atomically(scratch / "room.scene.json", scene_text(room, *world_from_asset * level));
        !written)
      return written;
    std::vector<std::byte> labels;
    for (uint16_t label : room.parts.label) {
      labels.push_back(static_cast<std::byte>(label & 0xff));
      labels.push_back(static_cast<std::byte>(label >> 8));
    }
    if (auto written = write_file_atomically(scratch / "labels.u16", labels); !written) return written;
    return write_file_atomically(scratch / "README.md", page_text(room));
  };
  auto written = write_all();
  std::vector<fs::path> names;
  for (const auto& file : fs::directory_iterator(scratch, error)) names.push_back(file.path().filename());
  for (const fs::path& name : names) {
    if (!written) break;
    fs::rename(scratch / name, folder / name, error);
    if (error) written = file_error(folder / name, "cannot be written", error);
    if (written) note_written(folder / name);
  }
  fs::remove_all(scratch, error);
  if (!written && is_new) fs::remove(folder, error);  // if it is empty
  return written;
}

}  // namespace livegs
