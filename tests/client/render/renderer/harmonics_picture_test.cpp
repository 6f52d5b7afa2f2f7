// SPDX-License-Identifier: Apache-2.0
// Colours of rotated kernels, from skinning to the picture, against closed forms: each coefficient of each
// band, for posed kernels, rigid bodies and elastic bodies, drawn by the reference and by the device.
#include "client/render/renderer/renderer_fixture.h"
#include "common/skin/kernels/rest_bodies.h"
#include "common/splat/project/real_harmonics.h"

namespace livegs {
namespace {

enum class Ride { Posed, Rigid, Lattice };

struct Turned {
  GaussianAsset asset;
  PosedKernels kernels;
  Eigen::Quaterniond world_from_asset;  // in closed form
  Eigen::Vector3d position_m;
};

void skin(const RestBody& rest, const ObjectDrivers& drivers, Turned& turned) {
  const auto bindings = bind_kernels(turned.asset, rest);
  ASSERT_TRUE(bindings) << bindings.error().message;
  skin_kernels(turned.asset, rest, *bindings, drivers, turned.kernels);
}

// A kernel with one coefficient; its asset is rotated differently each time. Elastic bodies are stretched as
// well, which must not affect the colour: it rotates with the polar rotation of the deformation.
Turned turned_by(Ride ride, int k, uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::Quaterniond turn = testing::random_rotation(random);
  const Eigen::Vector3d shift_m = testing::uniform3(random, -0.3, 0.3);
  Turned turned;
  if (ride == Ride::Posed) {
    turned.asset = synthetic::one_harmonic(k);
    turned.world_from_asset = turn;
    turned.position_m = shift_m;
    turned.kernels.positions_m = {shift_m.cast<float>()};
    turned.kernels.covariances_m2 = {synthetic::covariance(turn, Eigen::Vector3d::Constant(0.3))};
    turned.kernels.world_from_asset = {turn.cast<float>()};
    return turned;
  }
  RestBody rest;
  Eigen::Vector3d at_rest_m = testing::uniform3(random, -0.2, 0.2);
  if (ride == Ride::Rigid) {
    rest.kind = DriverKind::Rigid;
    testing::place(rest, seed);
    rest.bodies = {{testing::uniform3(random, -0.2, 0.2), testing::random_rotation(random)}};
  } else {
    rest = testing::lattice_body(3, 4, 2, 0.1);
    testing::place(rest, seed);
    at_rest_m = testing::points_inside(rest, 1, seed)[0];
  }
  const Similarity& to_object = rest.object_from_asset;
  turned.asset = synthetic::one_harmonic(
      k, to_object.rotation.conjugate() * ((at_rest_m - to_object.translation_m) / to_object.scale));
  turned.world_from_asset = turn * rest.object_from_asset.rotation;
  if (ride == Ride::Rigid) {
    const Pose world_from_object{shift_m, turn};
    ObjectDrivers drivers;
    drivers.poses = {world_from_object * rest.bodies[0]};
    turned.position_m = world_from_object * at_rest_m;
    skin(rest, drivers, turned);
  } else {
    Eigen::Matrix3d stretch;  // symmetric and positive
    stretch << 1.2, 0.1, -0.05, 0.1, 0.9, 0.08, -0.05, 0.08, 1.1;
    const Eigen::Matrix3d f = turn.toRotationMatrix() * stretch;
    turned.position_m = f * at_rest_m + shift_m;
    skin(rest,
         testing::moved_drivers(rest,
                                [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return f * x + shift_m; }),
         turned);
  }
  return turned;
}

void expect_closed_forms(SplatRenderer& renderer, Ride ride) {
  uint64_t version = 0;
  synthetic::Random random(31);
  for (int k = 0; k < synthetic::kBandCoefficients; ++k) {
    for (int turn = 0; turn < 3; ++turn) {
      const Turned turned = turned_by(ride, k, 100 * static_cast<uint64_t>(k) + static_cast<uint64_t>(turn));
      ASSERT_EQ(turned.kernels.positions_m.size(), 1u);
      const Eigen::Vector3d towards = random.rotation() * Eigen::Vector3d::UnitZ();
      const Camera eye = synthetic::eye_towards(turned.position_m, towards);
      ++version;
      const RenderedObject object{{&turned.asset, &turned.kernels, 0}, version, version};
      std::vector<Image> images;
      const auto drawn = renderer.draw({&object, 1}, {&eye, 1}, {}, images);
      ASSERT_TRUE(drawn) << drawn.error().message;
      const Eigen::Vector3d expected = synthetic::one_harmonic_shows(k, turned.world_from_asset, towards);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(images[0].at(16, 12)[c], expected[c], 1e-4)
            << "coefficient " << k << ", turn " << turn << ", channel " << c;
    }
  }
}

TEST(HarmonicsPictures, RigidBodyMatchesClosedFormOnCpu) {
  expect_closed_forms(*create_cpu_renderer(), Ride::Rigid);
}
TEST(HarmonicsPictures, ElasticBodyMatchesClosedFormOnCpu) {
  expect_closed_forms(*create_cpu_renderer(), Ride::Lattice);
}

class HarmonicsOnTheDevice : public VulkanPictures {
 protected:
  void SetUp() override {
    VulkanPictures::SetUp();
    if (device_) make_renderer({.precision = BlendPrecision::Full, .read_blended = true});
  }
};

TEST_F(HarmonicsOnTheDevice, PosedKernelsMatchClosedForm) { expect_closed_forms(*renderer_, Ride::Posed); }
TEST_F(HarmonicsOnTheDevice, RigidBodyMatchesClosedForm) { expect_closed_forms(*renderer_, Ride::Rigid); }
TEST_F(HarmonicsOnTheDevice, ElasticBodyMatchesClosedForm) { expect_closed_forms(*renderer_, Ride::Lattice); }

}  // namespace
}  // namespace livegs
