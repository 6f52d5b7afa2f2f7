// SPDX-License-Identifier: Apache-2.0
#include "hidden_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/motion/point_motion.h"
#include "fit/motion/surface_view.h"
#include "json/json_message.h"
#include "scene/build/build_cache.h"
#include "splat/project/project_kernels.h"

namespace livegs {

v1::Scene scene_of(const std::string& json) {
  v1::Scene scene;
  const auto parsed = parse_json_message(json, scene);
  EXPECT_TRUE(parsed) << parsed.error().message;
  return scene;
}

std::string held_block(double modulus_pa, double spacing_m) {
  return R"({ "gravity_m_s2": [0, 0, 0], "objects": [ { "name": "block", "shape": { "box": { "size_m": [0.1, 0.3, 0.1] } },
      "spacing_m": )" +
         std::to_string(spacing_m) +
         R"(, "physics": { "behavior": "ELASTIC", "density_kg_m3": 500, "damping": 0.1, "youngs_modulus_pa": )" +
         std::to_string(modulus_pa) +
         R"( }, "regions": [ { "box": { "max_m": [1, -0.1, 1] }, "fixed": true } ] } ],
      "events": [ { "time_s": 0.05, "force": { "object": "block", "point_m": [0, 0.14, 0], "force_n": [3, 0, 0],
                                               "duration_s": 0.2 } } ] })";
}

PointTracks exact_tracks(const HiddenMotion& motion, size_t count) {
  const FitRequest& request = motion.request;
  const auto scene = Scene::build(motion.truth, request.scene.folder, "truth", {});
  EXPECT_TRUE(scene) << scene.error().message;
  std::vector<std::string> names;
  for (const v1::Object& object : motion.truth.objects()) names.push_back(object.name());
  const auto view = SurfaceView::of(*scene, request.camera, names);
  EXPECT_TRUE(view);
  std::vector<Eigen::Vector2d> pixels;
  for (const std::string& name : names) {
    const std::vector<uint8_t> mask = view->mask(name, 2);
    for (size_t i = 0; i < mask.size(); ++i)
      if (mask[i] != 0)
        pixels.emplace_back(static_cast<double>(i % static_cast<size_t>(request.camera.width)) + 0.5,
                            static_cast<double>(i / static_cast<size_t>(request.camera.width)) + 0.5);
  }
  EXPECT_GT(pixels.size(), count);
  std::vector<TrackedPoint> points;
  PointTracks tracks;
  std::vector<Eigen::Vector2d> first;
  for (size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d& px = pixels[k * pixels.size() / count];
    if (const auto point = view->at(px)) {
      points.push_back(*point);
      first.push_back(px);
    }
  }
  const PointMotion simulated(request.scene.folder, "truth", points, std::make_shared<BuildCache>());
  const auto paths = simulated.simulate(motion.truth, motion.seconds);
  EXPECT_TRUE(paths) << paths.error().message;
  for (double time_s = 0; time_s <= motion.seconds; time_s += 1 / motion.frame_rate_hz)
    tracks.times_s.push_back(time_s);
  const Projection projection(request.camera);
  for (size_t point = 0; point < points.size(); ++point) {
    for (const double time_s : tracks.times_s) {
      const Eigen::Vector3d t =
          projection.image_from_world * (paths->at(point, time_s) - projection.position_m);
      tracks.positions_px.emplace_back(projection.focal_x_px * t.x() / t.z() + projection.centre_x_px,
                                       projection.focal_y_px * t.y() / t.z() + projection.centre_y_px);
    }
  }
  return tracks;
}

void disturb(PointTracks& tracks, double noise_px, double wrong_share, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (size_t point = 0; point < tracks.points(); ++point) {
    const bool wrong = std::uniform_real_distribution<double>()(random) < wrong_share;
    Eigen::Vector2d drift = Eigen::Vector2d::Zero();
    for (size_t frame = 0; frame < tracks.frames(); ++frame) {
      Eigen::Vector2d& at = tracks.positions_px[point * tracks.frames() + frame];
      if (wrong) drift += 1.5 * Eigen::Vector2d(normal(random), normal(random));
      at += drift + noise_px * Eigen::Vector2d(normal(random), normal(random));
    }
  }
}

FittedValue value_of(const FitResult& result, const std::string& object, FitQuantity quantity) {
  for (const FittedValue& value : result.values)
    if (value.parameter.object == object && value.parameter.quantity == quantity) return value;
  ADD_FAILURE() << object << ": no " << names_of(quantity).name;
  return {};
}

}  // namespace livegs
