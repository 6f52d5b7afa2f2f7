// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/solve/first_frame.h"

#include <algorithm>
#include <cmath>

#include "scene/build/build_cache.h"
#include "scene/check/check_object.h"

namespace livegs {
namespace {

// Names and quantities that the request asks for.
Result<std::vector<std::pair<std::string, std::vector<FitQuantity>>>> wanted_objects(
    const FitRequest& request, const Scene& scene) {
  if (!request.objects.empty()) {
    for (const auto& [name, quantities] : request.objects)
      if (!scene.find_in_file(name)) return not_found(name + ": is no object of the scene");
    return request.objects;
  }
  std::vector<std::string> moving;
  std::string all;
  for (const SceneObject& object : scene.objects()) {
    if (object.environment || object.physics.behavior() == v1::Physics::STATIC) continue;
    moving.push_back(object.name);
    all += (all.empty() ? "" : ", ") + object.name;
  }
  if (moving.size() == 1) return std::vector{std::pair(moving[0], std::vector<FitQuantity>{})};
  if (moving.empty()) return invalid_argument("scene: has no object that moves; there is nothing to find");
  return invalid_argument("scene: has several objects that move; name those to fit: " + all);
}

}  // namespace

Result<FirstFrame> first_frame(const FitRequest& request, double time_s, std::shared_ptr<BuildCache> cache) {
  SceneOptions options;
  options.cache = std::move(cache);
  options.cut_fragile = false;
  FirstFrame first;
  first.file = request.scene.file;
  for (int i = 0; i < first.file.objects_size(); ++i)
    first.file.mutable_objects(i)->set_name(object_name(first.file.objects(i), i));
  auto scene = Scene::build(first.file, request.scene.folder, request.scene.name, options);
  if (!scene) return scene.error();
  auto wanted = wanted_objects(request, *scene);
  if (!wanted) return wanted.error();
  for (const auto& [name, quantities] : *wanted) {
    const SceneObject& object = *scene->find_in_file(name);
    auto parameters = fit_parameters(object, quantities);
    if (!parameters) return parameters.error();
    first.parameters.insert(first.parameters.end(), parameters->begin(), parameters->end());
    first.objects.push_back(name);
    first.mass_source[name] = source_name(object.physics.mass_kg());
    for (v1::Object& written : *first.file.mutable_objects())
      if (written.name() == name) written.mutable_physics()->set_behavior(object.physics.behavior());
  }
  const auto ticks =
      static_cast<uint64_t>(std::llround(std::max(0.0, time_s) * scene->world().settings().rate_hz));
  for (uint64_t tick = 0; tick < ticks; ++tick) scene->step();
  auto view = SurfaceView::of(*scene, request.camera, first.objects);
  if (!view) return view.error();
  first.view = std::move(*view);
  return first;
}

}  // namespace livegs
