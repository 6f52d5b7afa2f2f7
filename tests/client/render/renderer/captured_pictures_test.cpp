// SPDX-License-Identifier: Apache-2.0
// Captured assets drawn by the device and by the reference renderer: small assets, small pictures.
// picture_bench draws all sixteen at 480 x 360 in the nightly run.
#include "client/render/renderer/posed_assets.h"
#include "client/render/renderer/renderer_fixture.h"
#include "common/gaussian/shared_data.h"
#include "common/skin/kernels/rest_bodies.h"
#include "gaussian/asset_file.h"
#include "render/scene_view.h"

namespace livegs {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kTwist_rad_m = 1.5;
const RenderOptions kDark{.background = {0.08f, 0.08f, 0.1f}};

class CapturedPictures : public VulkanPictures, public ::testing::WithParamInterface<const char*> {
 protected:
  void expect_parity(const GaussianAsset& asset, const PosedKernels& kernels, View view, const char* name) {
    const RenderedObject object = rendered({&asset, &kernels, 0}, ++version_);
    const Camera eye = view_of(extent_of(kernels), view, kWidth, kHeight);
    const auto made = draw({&object, 1}, {&eye, 1}, kDark);
    const auto expected = oracle({&object, 1}, {&eye, 1}, kDark);
    ASSERT_EQ(made.size(), 1u);
    const double db = psnr_db(made[0], expected[0]);
    std::printf("%s, %s: %.1f dB\n", GetParam(), name, db);
    EXPECT_GE(db, kBar_db) << name;
    // The picture must not be empty: empty pictures always agree.
    double covered = 0;
    for (size_t i = 3; i < expected[0].pixels.size(); i += 4) covered += expected[0].pixels[i];
    EXPECT_GT(covered, 0.02 * kWidth * kHeight) << name;
  }
};

TEST_P(CapturedPictures, MatchReferenceFromAllViewsAndDeformed) {
  LIVEGS_NEEDS_SHARED_DATA();
  const auto file = read_asset(shared_data() / "splats" / GetParam());
  ASSERT_TRUE(file) << file.error().message;
  const PosedKernels still = pose_asset(file->asset), twisted = pose_asset(file->asset, kTwist_rad_m);
  // With the default options of the device, and blended in 16-bit floats, as on GPUs.
  for (const VulkanRendererOptions& options :
       {VulkanRendererOptions{},
        VulkanRendererOptions{.method = DrawMethod::Quads, .precision = BlendPrecision::Half}}) {
    make_renderer(options);
    for (const View view : {View::Front, View::Close, View::Inside})
      expect_parity(file->asset, still, view, name_of(view));
    expect_parity(file->asset, twisted, View::Front, "deformed");
  }
}

// Three bands, none, two, none; 8 to 59 thousand kernels.
INSTANTIATE_TEST_SUITE_P(Assets, CapturedPictures,
                         ::testing::Values("camera_leica/leica-sofort-top8192.ply",
                                           "ponytail_palm/ponytail_palm.ply", "playbot/playbot_31k.ply",
                                           "statues/massa.sog"));

class DeformedCapture : public VulkanPictures {};

// A captured asset as an elastic body that the device skins: upright, 0.5 m across, in a twisted and
// stretched lattice.
TEST_F(DeformedCapture, MatchesReferenceSkinnedOnCpu) {
  LIVEGS_NEEDS_SHARED_DATA();
  const auto file = read_asset(shared_data() / "splats" / "camera_leica/leica-sofort-top8192.ply");
  ASSERT_TRUE(file) << file.error().message;
  const auto asset = std::make_shared<const GaussianAsset>(file->asset);
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3f& position : asset->positions) bounds.extend(position.cast<double>());
  constexpr int kCells = 11;  // along each axis: 0.55 m
  constexpr double kCellWidth_m = 0.05;
  RestBody rest = testing::lattice_body(kCells, kCells, kCells, kCellWidth_m);
  rest.object_from_lattice.position_m.setConstant(-0.5 * kCells * kCellWidth_m);
  rest.object_from_asset.scale = 0.5 / bounds.sizes().maxCoeff();
  rest.object_from_asset.rotation =
      Eigen::Quaterniond(0, 1, 0, 0);  // half a turn about x: -Y is up in the file
  rest.object_from_asset.translation_m =
      -(rest.object_from_asset.rotation * (rest.object_from_asset.scale * bounds.center()));
  SceneView device(std::move(renderer_)), host;
  for (SceneView* view : {&device, &host}) {
    const auto added = view->add(1, asset, rest, false);
    ASSERT_TRUE(added) << added.error().message;
  }
  const Camera eye = look_at({0.25, 0.2, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 200, 150);
  std::vector<Image> undeformed;
  for (const double moment : {0.0, 0.5, 1.0}) {
    DriverFrame frame;
    frame.objects.push_back(testing::moved_drivers(rest, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
      return Eigen::AngleAxisd(3 * moment * x.y(), Eigen::Vector3d::UnitY()) *
             Eigen::Vector3d(x.x(), (1 + 0.2 * moment) * x.y(), x.z());
    }));
    frame.objects[0].object_id = 1;
    std::vector<Image> made, expected;
    ASSERT_TRUE(device.draw(frame, {&eye, 1}, made));
    EXPECT_EQ(device.last_times().objects_moved, 1u);
    EXPECT_EQ(device.last_times().objects_skinned, 0u);  // none on the host
    ASSERT_TRUE(host.draw(frame, {&eye, 1}, expected));
    EXPECT_EQ(host.last_times().objects_skinned, 1u);
    for (float& value : expected[0].pixels) value = std::min(value, 1.0f);
    const double db = psnr_db(made[0], expected[0]);
    std::printf("deformed by %.1f: %.1f dB\n", moment, db);
    EXPECT_GE(db, kBar_db) << moment;
    // The picture is not empty and differs from the one at rest.
    double covered = 0;
    for (size_t i = 3; i < expected[0].pixels.size(); i += 4) covered += expected[0].pixels[i];
    EXPECT_GT(covered, 0.05 * eye.width * eye.height) << moment;
    if (moment == 0) {
      undeformed = expected;
    } else {
      EXPECT_LT(psnr_db(made[0], undeformed[0]), 30) << moment;
    }
  }
}

}  // namespace
}  // namespace livegs
