// SPDX-License-Identifier: Apache-2.0
// Captured assets drawn by the device and by the reference renderer: small assets, small pictures.
// picture_bench draws all sixteen at 480 x 360 in the nightly run.
#include "client/render/renderer/posed_assets.h"
#include "client/render/renderer/renderer_fixture.h"
#include "common/gaussian/shared_data.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kTwist_rad_m = 1.5;
const RenderOptions kDark{.background = {0.08f, 0.08f, 0.1f}};

class CapturedPictures : public VulkanPictures, public testing::WithParamInterface<const char*> {
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
                         testing::Values("camera_leica/leica-sofort-top8192.ply",
                                         "ponytail_palm/ponytail_palm.ply", "playbot/playbot_31k.ply",
                                         "statues/massa.sog"));

}  // namespace
}  // namespace livegs
