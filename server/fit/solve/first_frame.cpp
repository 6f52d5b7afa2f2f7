// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/solve/first_frame.h"

#include <algorithm>
#include <cmath>

#include "analysis/estimate/physics_values.h"
#include "core/text/format_text.h"
#include "core/text/shown_text.h"
#include "scene/build/build_cache.h"
#include "scene/check/check_object.h"

namespace livegs {
namespace {

constexpr double kMaxFirstFrame_s = 3600;
// Two buffers of floats and ids for each pixel: 2 GB. A video of 8192 x 4320 has 35 million.
constexpr double kMaxCameraPixels = 40e6;
constexpr uint64_t kProgressTicks = 500;

// Requested names and quantities.
Result<std::vector<std::pair<std::string, std::vector<FitQuantity>>>> wanted_objects(
    const FitRequest& request, const Scene& scene) {
  if (!request.objects.empty()) {
    for (const auto& [name, quantities] : request.objects)
      if (!scene.find_in_file(name))
        return not_found(shown_line(name) + ": is not an object of the scene; name one of its objects");
    for (size_t i = 0; i < request.objects.size(); ++i) {
      for (size_t j = 0; j < i; ++j)
        if (request.objects[i].first == request.objects[j].first)
          return invalid_argument(shown_line(request.objects[i].first) +
                                  ": is named twice; give all its quantities at once");
    }
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

Result<FirstFrame> first_frame(const FitRequest& request, double time_s, std::shared_ptr<BuildCache> cache,
                               const FitProgress& progress) {
  if (!(time_s >= 0 && time_s <= kMaxFirstFrame_s))
    return invalid_argument(format_text("first frame: is at %.6g s of the scene; it must be at 0 to %.0f s",
                                        time_s, kMaxFirstFrame_s));
  const double pixels = static_cast<double>(request.camera.width) * request.camera.height;
  if (pixels > kMaxCameraPixels)
    return invalid_argument(format_text("camera: has %d x %d pixels; give at most %.0f million",
                                        request.camera.width, request.camera.height,
                                        1e-6 * kMaxCameraPixels));
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
    first.mass_source[name] = source_name(object.physics.mass_kg().source());
    for (v1::Object& written : *first.file.mutable_objects())
      if (written.name() == name) written.mutable_physics()->set_behavior(object.physics.behavior());
  }
  const auto ticks = static_cast<uint64_t>(std::llround(time_s * scene->world().settings().rate_hz));
  for (uint64_t tick = 0; tick < ticks; ++tick) {
    scene->step();
    if (tick % kProgressTicks == kProgressTicks - 1 && progress &&
        !progress(format_text("to the first frame: %.0f of %.0f s simulated",
                              static_cast<double>(tick) / scene->world().settings().rate_hz, time_s)))
      return Error{ErrorCode::Unavailable, "first frame: the simulation was stopped"};
  }
  auto view = SurfaceView::of(*scene, request.camera, first.objects);
  if (!view) return view.error();
  first.view = std::move(*view);
  return first;
}

}  // namespace livegs
