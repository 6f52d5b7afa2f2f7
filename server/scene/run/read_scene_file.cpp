// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/file.h"
#include "core/text/path_ending.h"
#include "gaussian/asset_name.h"
#include "json/json_message.h"
#include "scene/check/check_scene.h"
#include "scene/run/scene_of_asset.h"
#include "scene/scene.h"

namespace livegs {
namespace {

// A folder with exactly one scene file stands for that scene.
std::optional<std::filesystem::path> only_scene_file(const std::filesystem::path& folder) {
  std::optional<std::filesystem::path> found;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(folder, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    if (!has_ending(at->path().string(), ".scene.json")) continue;
    if (found) return std::nullopt;
    found = at->path();
  }
  return found;
}

}  // namespace

Result<v1::Scene> read_scene_file(const std::filesystem::path& path) {
  auto text = read_text_file(path, 16 << 20);
  if (!text) return text.error();
  const std::string name = path.filename().string();

  v1::Scene scene;
  if (auto parsed = parse_json_message(*text, scene); !parsed)
    return invalid_data(name + ": " + parsed.error().message);
  if (auto checked = check_scene(scene); !checked)
    return Error{checked.error().code, name + ": " + checked.error().message};
  return scene;
}

Result<SceneText> read_scene(const std::filesystem::path& path, bool drop) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) {
    if (is_asset_index(path) || asset_ending(path.string())) {
      auto scene = scene_of_asset(path, drop);
      if (!scene) return scene.error();
      return SceneText{std::move(*scene), path.parent_path(),
                       asset_stem(std::filesystem::absolute(path).lexically_normal()).filename().string()};
    }
    auto file = read_scene_file(path);
    if (!file) return file.error();
    return SceneText{std::move(*file), path.parent_path(), path.filename().string(), true};
  }
  if (const auto scene_file = only_scene_file(path)) return read_scene(*scene_file);
  auto file = scene_of_folder(path, drop);
  if (!file) return file.error();
  return SceneText{std::move(*file), path,
                   std::filesystem::absolute(path).lexically_normal().filename().string()};
}

}  // namespace livegs
