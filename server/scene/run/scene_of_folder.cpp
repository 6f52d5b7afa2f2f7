// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/log.h"
#include "core/parallel_for.h"
#include "core/text/path_ending.h"
#include "gaussian/asset_name.h"
#include "scene/build/place_asset.h"
#include "scene/check/check_scene.h"
#include "scene/run/scene_of_asset.h"
#include "scene/scene.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxFolderDepth = 3;  // subfolder levels that are searched
constexpr double kGap_m = 0.25;     // gap between neighbours

// Height above the floor from which objects are dropped. Slender objects start lower, because a
// fall on an uneven captured base would tip them over. The energy to topple scales with (width / height)².
constexpr double kDropHeight_m = 0.15;
double drop_height_m(const Eigen::Vector3d& size_m) {
  const double slenderness = std::min(size_m.x(), size_m.z()) / size_m.y();
  return kDropHeight_m * std::clamp(0.5 * slenderness * slenderness, 0.02, 1.0);
}

// Preference among files with the same stem: exact formats before quantised ones.
constexpr std::string_view kPreferred[] = {".ply",  ".glb", ".gltf", ".spz", ".sog", ".compressed.ply",
                                           ".splat"};
constexpr int kRankOfIndex = 4;  // of the files of an unpacked .sog

// Returns the preference rank of an asset; nothing if the file is not one.
std::optional<int> asset_rank(const fs::path& path) {
  if (is_asset_index(path)) return kRankOfIndex;
  const auto ending = asset_ending(path.string());
  if (!ending) return std::nullopt;
  return static_cast<int>(std::find(std::begin(kPreferred), std::end(kPreferred), *ending) -
                          std::begin(kPreferred));
}

bool names_environment(const std::string& stem) {
  const std::string name = fs::path(stem).filename().string();
  return name.starts_with("room") || name.starts_with("environment") || name.starts_with("background");
}

// Finds the assets under `folder`, one per stem, sorted by path.
std::map<std::string, fs::path> find_assets(const fs::path& folder) {
  std::map<std::string, std::pair<int, fs::path>> best;
  std::vector<std::string> streamed;  // folders of streamed assets: their chunks are not assets
  std::error_code error;
  auto walk = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && walk != fs::recursive_directory_iterator(); walk.increment(error)) {
    if (walk.depth() >= kMaxFolderDepth) walk.disable_recursion_pending();
    if (!walk->is_regular_file(error)) continue;
    const auto rank = asset_rank(walk->path());
    if (!rank) continue;
    const std::string stem = asset_stem(walk->path()).string();
    if (lower_case(walk->path().filename().string()) == "lod-meta.json") streamed.push_back(stem + "/");
    const auto [at, fresh] = best.try_emplace(stem, *rank, walk->path());
    if (!fresh && *rank < at->second.first) at->second = {*rank, walk->path()};
  }
  std::erase_if(best, [&](const auto& one) {
    return std::any_of(streamed.begin(), streamed.end(),
                       [&](const std::string& above) { return one.first.starts_with(above); });
  });
  std::map<std::string, fs::path> assets;
  for (const auto& [stem, ranked] : best) assets[stem] = ranked.second;
  return assets;
}

struct PlacedObject {
  std::string stem;
  fs::path path;
  std::string name;
  Eigen::AlignedBox3d bounds;  // object frame
  double scale = 1.0;          // metres per unit
  bool scale_is_free = false;  // a guess from the size alone
};

// Assets of one folder were captured in one unit: those whose scale is a guess from their size alone get the
// smallest of these scales, that of the largest.
void share_scale(std::vector<PlacedObject>& standing) {
  std::map<fs::path, double> shared;
  for (const PlacedObject& one : standing) {
    if (!one.scale_is_free) continue;
    const auto [at, fresh] = shared.try_emplace(fs::path(one.stem).parent_path(), one.scale);
    at->second = std::min(at->second, one.scale);
  }
  for (PlacedObject& one : standing) {
    if (!one.scale_is_free) continue;
    const double scale = shared.at(fs::path(one.stem).parent_path());
    const Eigen::Vector3d low = scale / one.scale * one.bounds.min(),
                          high = scale / one.scale * one.bounds.max();
    one.bounds = {low, high};
    one.scale = scale;
  }
}

v1::Scene floor_scene() {
  v1::Scene scene;
  v1::Collider& floor = *scene.mutable_environment()->add_colliders();
  floor.mutable_plane();
  floor.set_friction(0.6);
  return scene;
}

}  // namespace

Result<SceneText> new_scene(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    return SceneText{floor_scene(), path, fs::absolute(path).lexically_normal().filename().string()};
  }
  const std::string name = path.filename().string();
  if (!has_ending(name, ".scene.json"))
    return invalid_argument(
        path.string() + ": is not a folder; give one, or the name of a new file that ends in .scene.json");
  if (fs::exists(path, error)) return invalid_argument(path.string() + ": exists; open it without --new");
  const fs::path folder = path.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    return not_found(folder.string() + ": no such folder; create it first");
  return SceneText{floor_scene(), folder, name, true};
}

namespace {

// Places assets, by stem, on a floor. Paths in the scene are relative to `folder`. `with_room`: the first
// asset that is named like a room is the environment.
Result<v1::Scene> scene_of_assets(const std::map<std::string, fs::path>& assets, const fs::path& folder,
                                  bool drop, bool with_room) {
  v1::Scene scene = floor_scene();

  std::vector<PlacedObject> standing;
  std::set<std::string> names;
  for (const auto& [stem, path] : assets) {
    if (with_room && names_environment(stem) && scene.environment().asset().empty()) {
      scene.mutable_environment()->set_asset(fs::relative(path, folder).string());
      continue;
    }
    PlacedObject one;
    one.stem = stem;
    one.path = path;
    one.name = fs::path(stem).filename().string();
    if (!names.insert(one.name).second) one.name = fs::path(stem).lexically_relative(folder).string();
    names.insert(one.name);
    standing.push_back(std::move(one));
  }
  if (standing.empty()) {
    return not_found(folder.string() + ": contains no splat assets (" + kAssetEndings +
                     ") and no *.scene.json; give another folder");
  }
  std::vector<std::string> failures(standing.size());
  parallel_for(standing.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      auto placed = place_asset(standing[i].path, standing[i].name, std::nullopt, "", standing[i].name);
      if (!placed) {
        failures[i] = placed.error().message;
        continue;
      }
      for (const Eigen::Vector3d& point : placed->body_points_m) standing[i].bounds.extend(point);
      standing[i].scale = placed->object_from_asset.scale;
      standing[i].scale_is_free = !placed->scale_known && !placed->scale_by_name;
    }
  });
  for (const std::string& failure : failures) {
    if (!failure.empty()) log_warn("asset skipped: %s", failure.c_str());
  }
  std::erase_if(standing, [](const PlacedObject& one) { return one.bounds.isEmpty(); });
  if (standing.empty()) return invalid_data(folder.string() + ": no asset can be read; see the log");

  share_scale(standing);

  // Places the objects in rows, tallest at the back. Rows are centred on x = 0 and the first is at z = 0.
  std::stable_sort(standing.begin(), standing.end(), [](const PlacedObject& a, const PlacedObject& b) {
    return a.bounds.sizes().y() > b.bounds.sizes().y();
  });
  const auto across = static_cast<size_t>(std::ceil(std::sqrt(1.6 * static_cast<double>(standing.size()))));
  double z = 0;
  for (size_t begin = 0; begin < standing.size(); begin += across) {
    const size_t end = std::min(begin + across, standing.size());
    double width = -kGap_m, depth = 0;
    for (size_t i = begin; i < end; ++i) {
      width += standing[i].bounds.sizes().x() + kGap_m;
      depth = std::max(depth, standing[i].bounds.sizes().z());
    }
    double x = -0.5 * width;
    for (size_t i = begin; i < end; ++i) {
      const PlacedObject& one = standing[i];
      v1::Object& object = *scene.add_objects();
      object.set_name(one.name);
      object.set_asset(fs::relative(one.path, folder).string());
      const Eigen::Vector3d size = one.bounds.sizes();
      object.set_standing(!drop);
      if (one.scale_is_free) object.set_assumed_scale(one.scale);
      const double lift_m = drop ? drop_height_m(size) : 0.0;
      const Eigen::Vector3d target(x + 0.5 * size.x(), 0.5 * size.y() + lift_m, z + 0.5 * depth);
      const Eigen::Vector3d position = target - one.bounds.center();
      for (double coordinate : position) object.mutable_pose()->add_position_m(coordinate);
      x += size.x() + kGap_m;
    }
    z += depth + kGap_m;
  }
  return scene;
}

}  // namespace

Result<v1::Scene> scene_of_folder(const fs::path& folder, bool drop) {
  return scene_of_assets(find_assets(folder), folder, drop, true);
}

Result<v1::Scene> scene_of_asset(const fs::path& path, bool drop) {
  std::error_code error;
  if (!fs::exists(path, error)) return not_found(path.string() + ": no such file; check the path");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::string stem = asset_stem(fs::absolute(path).lexically_normal()).string();
  return scene_of_assets({{stem, path}}, folder, drop, false);
}

}  // namespace livegs
