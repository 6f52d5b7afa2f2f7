// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/fit/rebase_scene.h"

namespace livegs {

v1::Scene rebase_scene(v1::Scene scene, const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto moved = [&](std::string* path) {
    if (path->empty()) return;
    std::error_code error;
    const auto there = std::filesystem::proximate(std::filesystem::absolute(from / *path),
                                                  std::filesystem::absolute(to), error);
    if (!error) *path = there.string();
  };
  if (scene.has_environment()) {
    v1::Environment& environment = *scene.mutable_environment();
    moved(environment.mutable_asset());
    moved(environment.mutable_labels());
    for (v1::Collider& collider : *environment.mutable_colliders())
      if (collider.shape_case() == v1::Collider::kMesh) moved(collider.mutable_mesh());
  }
  for (v1::Object& object : *scene.mutable_objects()) {
    if (object.form_case() == v1::Object::kAsset) moved(object.mutable_asset());
    if (object.form_case() == v1::Object::kPoints) moved(object.mutable_points());
  }
  for (v1::Event& event : *scene.mutable_events()) {
    if (event.has_grab()) moved(event.mutable_grab()->mutable_path());
    if (event.has_pull()) moved(event.mutable_pull()->mutable_path());
  }
  return scene;
}

}  // namespace livegs
