// SPDX-License-Identifier: Apache-2.0
// Kernels follow their cells. The effect of a prescribed deformation is tested from the scene file to the
// covariance and the picture.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rates.h"
#include "scene/scene.h"
#include "scene/views/scene_drawing.h"
#include "scratch_folder.h"
#include "splat/frame_bounds.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Scene scene_of(const std::string& text) {
  ScratchFolder folder;
  auto scene = Scene::load(folder.write("test.scene.json", text), {});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

Matrix3d matrix_of(const Symmetric3f& s) {
  Matrix3d m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return m;
}

void step(Scene& scene, double seconds) {
  const auto ticks = static_cast<int>(std::lround(seconds * scene.world().settings().rate_hz));
  for (int tick = 0; tick < ticks; ++tick) scene.step();
}

struct Ramp {
  const char* name;
  const char* text;  // the matrix as written in the scene file
  Matrix3d matrix;
};

class AffineRamp : public testing::TestWithParam<std::tuple<Ramp, double>> {};

// A bar whose outer nodes follow the ramp. Co is at most 0.26 (E 1e4, 8 substeps); below kBoundaryCourant the
// interior follows within 2 %, the bar. The covariance is computed from F itself in single precision, so its
// bar is 1e-3.
TEST_P(AffineRamp, MovesAndDeformsTheKernels) {
  const auto& [ramp, rate_hz] = GetParam();
  Scene scene = scene_of(R"({ "gravity_m_s2": [0, 0, 0], "rate_hz": )" + std::to_string(rate_hz) +
                         R"(, "substeps": 8, "objects": [
      { "name": "bar", "shape": { "box": { "size_m": [0.4, 0.1, 0.1] } }, "spacing_m": 0.0125,
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e4, "poisson_ratio": 0.3,
                     "damping": 0.5 },
        "regions": [ { "name": "skin", "boundary": true, "motion": { "affine_ramp": { "matrix": )" +
                         ramp.text + R"(, "start_s": 0, "end_s": 2 } } } ] } ] })");
  SceneDrawing drawing;
  drawing.keep_deformation_gradients(true);
  ASSERT_TRUE(drawing.pose(scene));
  const uint32_t bar = scene.find("bar")->id;
  const std::vector<Symmetric3f> rest = drawing.kernels(bar).covariances_m2;
  step(scene, 4.0);

  double worst = 0.0;
  for (const ParticleState& p : scene.world().elastic_body(bar)->particles()) {
    worst = std::max(worst, (p.deformation_gradient - ramp.matrix).norm() / ramp.matrix.norm());
  }
  EXPECT_LT(worst, 0.02);

  auto posed = drawing.pose(scene);
  ASSERT_TRUE(posed) << posed.error().message;
  std::vector<double> errors;
  for (size_t k = 0; k < rest.size(); ++k) {
    const Matrix3d f = drawing.deformation_gradients(bar)[k].cast<double>();
    const Matrix3d expected = f * matrix_of(rest[k]) * f.transpose();
    errors.push_back((matrix_of(drawing.kernels(bar).covariances_m2[k]) - expected).norm() / expected.norm());
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 1e-3);
}

INSTANTIATE_TEST_SUITE_P(
    Kernels, AffineRamp,
    testing::Combine(testing::Values(Ramp{"Stretch", "[1.5,0,0, 0,1,0, 0,0,0.8]",
                                          (Matrix3d() << 1.5, 0, 0, 0, 1, 0, 0, 0, 0.8).finished()},
                                     Ramp{"Shear", "[1,1,0, 0,1,0, 0,0,1]",
                                          (Matrix3d() << 1, 1, 0, 0, 1, 0, 0, 0, 1).finished()}),
                     testing::ValuesIn(rates_hz())),
    [](const auto& one) { return std::get<0>(one.param).name + rate_name(std::get<1>(one.param)); });

// A cube that is compressed to 80 % and released looks as before: 40 dB against the initial picture.
class KernelDeformation : public testing::TestWithParam<double> {};

TEST_P(KernelDeformation, LooksTheSameAfterRelease) {
  Scene scene = scene_of(R"({ "gravity_m_s2": [0, 0, 0], "rate_hz": )" + std::to_string(GetParam()) +
                         R"(, "substeps": 4, "objects": [
      { "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } },
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 5e4, "damping": 0.2 },
        "regions": [ { "name": "press", "boundary": true, "motion": { "affine_ramp": {
                       "matrix": [1,0,0, 0,0.8,0, 0,0,1], "start_s": 0, "end_s": 0.5 } } } ] } ],
      "events": [ { "time_s": 1.0, "release_region": { "object": "cube", "region": "press" } } ] })");
  const Camera camera = frame_bounds(scene.bounds_m(), 320, 240);
  Rasteriser rasteriser;
  SceneDrawing drawing;
  const auto picture = [&] {
    auto posed = drawing.pose(scene);
    EXPECT_TRUE(posed) << posed.error().message;
    RasterisedView view;
    rasteriser.draw(*posed, camera, {}, view);
    return view.image;
  };
  const Image before = picture();
  step(scene, 0.9);
  const Image squashed = picture();
  step(scene, 4.0);
  EXPECT_LT(psnr_db(before, squashed), 30.0);  // it was compressed
  EXPECT_GT(psnr_db(before, picture()), 40.0);
}

INSTANTIATE_TEST_SUITE_P(Rates, KernelDeformation, testing::ValuesIn(rates_hz()),
                         [](const auto& one) { return rate_name(one.param); });

}  // namespace
}  // namespace livegs
