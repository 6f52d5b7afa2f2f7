// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/check/sidecar_paths.h"

#include <map>

#include "analysis/physics_file.h"
#include "core/text/path_ending.h"
#include "scene/check/check_object.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// The file whose sidecar is in the same folder. Empty for a shape of a scene without a file.
fs::path described_file(const v1::Object& object, const fs::path& folder, const std::string& scene_name) {
  switch (object.form_case()) {
    case v1::Object::kAsset:
      return (folder / object.asset()).lexically_normal();
    case v1::Object::kPoints:
      return (folder / object.points()).lexically_normal();
    default:
      return has_ending(scene_name, ".scene.json") ? folder / fs::path(scene_name).stem() : fs::path();
  }
}

}  // namespace

std::vector<fs::path> sidecar_paths(const v1::Scene& scene, const fs::path& folder,
                                    const std::string& scene_name) {
  std::map<fs::path, int> users;  // by sidecar, so that cup.ply and cup.spz share one
  std::vector<fs::path> paths;
  for (const v1::Object& object : scene.objects()) {
    const fs::path file = described_file(object, folder, scene_name);
    if (!file.empty()) ++users[physics_file_path(file)];
  }
  for (int i = 0; i < scene.objects_size(); ++i) {
    const v1::Object& object = scene.objects(i);
    const fs::path file = described_file(object, folder, scene_name);
    fs::path path;
    if (!file.empty()) {
      const fs::path own = physics_file_path(file, object_name(object, i));
      std::error_code ignored;
      const bool shares = object.form_case() == v1::Object::kShape || users.at(physics_file_path(file)) > 1;
      path = shares || fs::exists(own, ignored) ? own : physics_file_path(file);
    }
    paths.push_back(std::move(path));
  }
  return paths;
}

}  // namespace livegs
