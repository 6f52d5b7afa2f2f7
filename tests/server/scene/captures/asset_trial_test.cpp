// SPDX-License-Identifier: Apache-2.0
#include "server/scene/captures/asset_trial.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace livegs::testing {
namespace {

namespace fs = std::filesystem;

// Two of the captured assets for three seconds. asset_trial_nightly_test covers all of them for twenty.
TEST(CapturedPhysics, StaysStableForThreeSeconds) {
  for (const char* name : {"ponytail_palm/ponytail_palm.ply", "camera_leica/leica-sofort-top8192.spz"}) {
    const fs::path path = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats" / name;
    if (!fs::exists(path)) GTEST_SKIP() << "the shared data is missing";
    expect_nothing_exploded(run_asset_trial(path.string(), TrialBody::Rigid, TrialAction::Stacked, 3.0));
    expect_nothing_exploded(run_asset_trial(path.string(), TrialBody::Elastic, TrialAction::Pulled, 3.0));
    const AssetTrial thrown = run_asset_trial(path.string(), TrialBody::Fragile, TrialAction::Thrown, 3.0);
    expect_nothing_exploded(thrown);
    EXPECT_TRUE(thrown.broke) << name;
  }
}

// Limp captures on each other, pressed into each other's edges, at rates that the nightly trial leaves out.
TEST(CapturedPhysics, LimpStacksGainNoEnergy) {
  const struct {
    const char* name;
    double rate_hz;
  } cases[] = {{"guitar/guitar.ply", 120.0}, {"guitar/guitar.ply", 100.0}, {"playbot/playbot_31k.ply", 66.0}};
  for (const auto& [name, rate_hz] : cases) {
    if (!fs::exists(fs::path(LIVEGS_SHARED_DATA_DIR) / "splats" / name))
      GTEST_SKIP() << "the shared data is missing";
  }
  for (const auto& [name, rate_hz] : cases) {
    const fs::path path = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats" / name;
    const AssetTrial trial =
        run_asset_trial(path.string(), TrialBody::Elastic, TrialAction::Stacked, 3.0, rate_hz);
    ASSERT_EQ(trial.error, "") << name;
    EXPECT_TRUE(trial.finite) << name;
    EXPECT_LT(trial.energy_ratio, 1.02) << name << " at " << rate_hz << " Hz";
  }
}

}  // namespace
}  // namespace livegs::testing
