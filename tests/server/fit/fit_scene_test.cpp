// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/log.h"
#include "core/parallel_for.h"
#include "hidden_motion.h"
#include "rates.h"

namespace livegs {
namespace {

// A bar that is held at one end and pulled down at the other for a quarter of a second.
std::string pulled_bar(double modulus_pa, double damping,
                       const std::string& mass = R"("density_kg_m3": 1000)") {
  return R"({ "gravity_m_s2": [0, 0, 0], "objects": [ { "name": "bar", "shape": { "box": { "size_m": [0.4, 0.06, 0.06] } },
      "spacing_m": 0.02, "physics": { "behavior": "ELASTIC", "youngs_modulus_pa": )" +
         std::to_string(modulus_pa) + R"(, "poisson_ratio": 0.3, "damping": )" + std::to_string(damping) +
         ", " + mass +
         R"( }, "regions": [ { "box": { "min_m": [-0.21, -0.1, -0.1], "max_m": [-0.17, 0.1, 0.1] }, "fixed": true } ] } ],
      "events": [ { "time_s": 0.1, "force": { "object": "bar", "point_m": [0.19, 0, 0], "force_n": [0, -1.5, 0.5],
                                              "duration_s": 0.25 } } ] })";
}

HiddenMotion hidden(const std::string& truth, const std::string& guess) {
  HiddenMotion motion;
  motion.truth = scene_of(truth);
  motion.request.scene.file = scene_of(guess);
  motion.request.scene.name = "bar.scene.json";
  motion.request.camera = look_at({0.3, 0.35, 0.7}, {0, -0.03, 0}, Eigen::Vector3d::UnitY(), 0.7, 640, 480);
  return motion;
}

FitResult fitted(const HiddenMotion& motion, const PointTracks& tracks) {
  set_log_level(LogLevel::Error);
  auto result = fit_scene(motion.request, tracks, {});
  EXPECT_TRUE(result) << result.error().message;
  if (!result) return {};
  for (const FittedValue& value : result->values)
    std::printf("%s %s: %.4g in %.4g to %.4g, shown %.3f\n", value.parameter.object.c_str(),
                names_of(value.parameter.quantity).name, value.best, value.low, value.high, value.shown);
  for (const std::string& note : result->notes) std::printf("note: %s\n", note.c_str());
  std::printf("spread %.3f px (before %.3f), scale %.4f, shift %.4f s, %zu simulations\n", result->spread_px,
              result->spread_before_px, result->picture_scale, result->shift_s, result->simulations);
  return *std::move(result);
}

TEST(FitScene, ExactTracksGiveTheHiddenStiffnessAndLoss) {
  const HiddenMotion motion = hidden(pulled_bar(2e5, 0.1), pulled_bar(2e6, 0.3));
  const FitResult result = fitted(motion, exact_tracks(motion, 60));
  const FittedValue modulus = value_of(result, "bar", FitQuantity::YoungsModulus);
  EXPECT_NEAR(modulus.best, 2e5, 0.02 * 2e5);
  EXPECT_LE(modulus.low, 2e5);
  EXPECT_GE(modulus.high, 2e5);
  EXPECT_NEAR(value_of(result, "bar", FitQuantity::Damping).best, 0.1, 0.05 * 0.1);
}

// One pixel of noise, one wrong track in twenty, a focal length that is up to 2 % wrong. The hidden values
// differ by seed.
TEST(FitScene, NoisyTracksOfAWrongCameraKeepTheirRanges) {
  const int seeds = seed_count(5);
  int stiffness_held = 0, loss_held = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    std::mt19937_64 random(static_cast<uint64_t>(seed));
    std::uniform_real_distribution<double> part(-1, 1);
    const double modulus_pa = 2e5 * std::exp(part(random)), damping = 0.12 * std::exp(part(random));
    HiddenMotion motion =
        hidden(pulled_bar(modulus_pa, damping), pulled_bar(1e5 * std::exp(2 * part(random)), 0.05));
    PointTracks tracks = exact_tracks(motion, 150);
    disturb(tracks, 1.0, 0.05, static_cast<uint64_t>(seed));
    const double focal = 1 + 0.02 * part(random);
    motion.request.camera.focal_x_px *= focal;
    motion.request.camera.focal_y_px *= focal;
    const FitResult result = fitted(motion, tracks);
    const FittedValue modulus = value_of(result, "bar", FitQuantity::YoungsModulus);
    const FittedValue loss = value_of(result, "bar", FitQuantity::Damping);
    EXPECT_NEAR(modulus.best, modulus_pa, 0.25 * modulus_pa) << "seed " << seed;
    EXPECT_NEAR(loss.best, damping, 0.25 * damping) << "seed " << seed;
    stiffness_held += modulus.low <= modulus_pa && modulus_pa <= modulus.high;
    loss_held += loss.low <= damping && damping <= loss.high;
  }
  // Of 10 ranges of 90 %, fewer than 7 hold with a probability of 1 %.
  EXPECT_GE(stiffness_held + loss_held, 3 * seeds / 2) << stiffness_held << " and " << loss_held;
}

// Without a known force the motion is the same for any mass, with the stiffness in proportion.
TEST(FitScene, StiffnessOverMassIsAllThatIsSeenWithoutAForce) {
  const auto bent = [](double modulus_pa, const std::string& mass) {
    std::string json = pulled_bar(modulus_pa, 0.05, mass);
    json.replace(json.find(R"("events")"), std::string::npos, R"("events": [] })");
    json.replace(json.find(R"("regions")"), 0, R"("initial_deformation": [1, 0, 0, 0.25, 1, 0, 0, 0, 1], )");
    return json;
  };
  HiddenMotion motion = hidden(bent(2e5, R"("mass_kg": 1.44)"), bent(4e5, R"("mass_kg": 0.72)"));
  const FitResult result = fitted(motion, exact_tracks(motion, 60));
  EXPECT_NEAR(value_of(result, "bar", FitQuantity::YoungsModulus).best, 1e5, 0.03 * 1e5);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_NE(result.notes[0].find("only youngs_modulus_pa / mass_kg"), std::string::npos) << result.notes[0];
  EXPECT_NE(result.notes[0].find("kg (scene) is kept"), std::string::npos) << result.notes[0];

  // An estimated mass makes the range as wide as its own.
  motion.request.scene.file = scene_of(bent(4e5, R"("friction": 0.5)"));
  const FitResult estimated = fitted(motion, exact_tracks(motion, 60));
  const FittedValue modulus = value_of(estimated, "bar", FitQuantity::YoungsModulus);
  const FittedValue mass = value_of(estimated, "bar", FitQuantity::Mass);
  EXPECT_FALSE(mass.parameter.asked);
  EXPECT_NEAR(modulus.best / mass.best, 2e5 / 1.44, 0.03 * 2e5 / 1.44);
  EXPECT_NEAR(std::log(modulus.high / modulus.low), std::log(mass.high / mass.low),
              0.25 * std::log(mass.high / mass.low));
}

// A known force shows mass and stiffness each.
TEST(FitScene, AKnownForceShowsTheMassToo) {
  HiddenMotion motion =
      hidden(pulled_bar(2e5, 0.1, R"("mass_kg": 1.44)"), pulled_bar(1e5, 0.1, R"("mass_kg": 2)"));
  motion.request.objects = {{"bar", {FitQuantity::YoungsModulus, FitQuantity::Damping, FitQuantity::Mass}}};
  const FitResult result = fitted(motion, exact_tracks(motion, 60));
  EXPECT_NEAR(value_of(result, "bar", FitQuantity::YoungsModulus).best, 2e5, 0.03 * 2e5);
  EXPECT_NEAR(value_of(result, "bar", FitQuantity::Mass).best, 1.44, 0.03 * 1.44);
  EXPECT_TRUE(result.notes.empty()) << result.notes[0];
}

// A box that slides stops after v² / (2 mu g).
std::string sliding_box(double friction) {
  return R"({ "environment": { "colliders": [ { "plane": {}, "friction": 0.5 } ] }, "objects": [ { "name": "box",
      "shape": { "box": { "size_m": [0.2, 0.1, 0.2] } }, "pose": { "position_m": [-0.3, 0.05, 0] },
      "velocity_m_s": [1.2, 0, 0], "physics": { "behavior": "RIGID", "mass_kg": 1, "friction": )" +
         std::to_string(friction) + "} } ] }";
}

TEST(FitScene, TheWayOfASlidingBoxShowsItsFriction) {
  HiddenMotion motion = hidden(sliding_box(0.3), sliding_box(0.9));
  motion.request.objects = {{"box", {FitQuantity::Friction}}};
  motion.request.camera = look_at({0.2, 0.8, 1.2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 640, 480);
  const FitResult result = fitted(motion, exact_tracks(motion, 40));
  EXPECT_NEAR(value_of(result, "box", FitQuantity::Friction).best, 0.3, 0.02 * 0.3);
}

TEST(FitScene, TheResultDoesNotDependOnTheNumberOfThreads) {
  const HiddenMotion motion = hidden(pulled_bar(2e5, 0.1), pulled_bar(1e5, 0.3));
  const PointTracks tracks = exact_tracks(motion, 30);
  std::vector<double> best;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    best.push_back(value_of(fitted(motion, tracks), "bar", FitQuantity::YoungsModulus).best);
  }
  set_thread_count(0);
  EXPECT_EQ(best[0], best[1]);
  EXPECT_EQ(best[0], best[2]);
}

TEST(FitScene, WhatCannotBeFittedIsNamed) {
  HiddenMotion motion = hidden(pulled_bar(2e5, 0.1), pulled_bar(1e5, 0.3));
  const PointTracks tracks = exact_tracks(motion, 30);
  const auto error_of = [&](const HiddenMotion& of, const PointTracks& with) {
    const auto result = fit_scene(of.request, with, {});
    return result ? std::string() : result.error().message;
  };
  PointTracks still = tracks;
  for (size_t point = 0; point < still.points(); ++point)
    for (size_t frame = 1; frame < still.frames(); ++frame)
      still.positions_px[point * still.frames() + frame] = still.at(point, 0);
  EXPECT_EQ(error_of(motion, still),
            "bar: does not move by more than two pixels in the recording; there is nothing to fit");
  HiddenMotion away = motion;
  away.request.camera = look_at({0, 0, 2}, {0, 0, 5}, Eigen::Vector3d::UnitY(), 0.7, 640, 480);
  EXPECT_NE(error_of(away, tracks).find("0 points are on bar"), std::string::npos) << error_of(away, tracks);
  PointTracks late = tracks;
  for (double& time_s : late.times_s) time_s += 1e8;
  EXPECT_NE(error_of(motion, late).find("it must be at 0 to 3600 s"), std::string::npos);
  PointTracks outside = tracks;
  outside.positions_px[5].x() = 1e6;
  EXPECT_NE(error_of(motion, outside).find("far outside of the picture"), std::string::npos);
  HiddenMotion large = motion;
  large.request.camera.width = large.request.camera.height = 16384;
  EXPECT_NE(error_of(large, tracks).find("give at most 40 million"), std::string::npos);
  HiddenMotion twice = motion;
  twice.request.objects = {{"bar", {FitQuantity::Damping, FitQuantity::Damping}}};
  EXPECT_EQ(error_of(twice, tracks), "bar: damping is named twice; name it once");
  twice.request.objects = {{"bar", {}}, {"bar", {FitQuantity::Damping}}};
  EXPECT_EQ(error_of(twice, tracks), "bar: is named twice; give all its quantities at once");
  HiddenMotion other = motion;
  other.request.objects = {{"rod", {}}};
  EXPECT_EQ(error_of(other, tracks), "rod: is not an object of the scene; name one of its objects");
  other.request.scene.file = scene_of(sliding_box(0.3));
  other.request.objects = {{"box", {FitQuantity::YoungsModulus}}};
  EXPECT_NE(error_of(other, tracks).find("is rigid and has no youngs_modulus_pa"), std::string::npos);
  other = motion;
  *other.request.scene.file.add_objects() = scene_of(sliding_box(0.3)).objects(0);
  EXPECT_EQ(error_of(other, tracks), "scene: has several objects that move; name those to fit: bar, box");
  other.request.scene.file.clear_objects();
  other.request.scene.file.clear_events();
  EXPECT_EQ(error_of(other, tracks), "scene: has no object that moves; there is nothing to find");
}

}  // namespace
}  // namespace livegs
