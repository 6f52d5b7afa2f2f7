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

}  // namespace
}  // namespace livegs::testing
