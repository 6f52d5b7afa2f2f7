// SPDX-License-Identifier: Apache-2.0
// All captured assets as three body types with four actions, for twenty seconds, at each rate; stacks of
// elastic bodies at more rates. Appends one row per trial to the file named by LIVEGS_TRIAL_CSV. Results are
// in tests/bench/results/<machine>/asset_trial.csv.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "server/scene/captures/asset_trial.h"

namespace livegs::testing {
namespace {

namespace fs = std::filesystem;

// One file of each capture; other formats of the same capture contain the same kernels.
std::vector<std::string> captures() {
  return {"camera_leica/leica-sofort-top8192.ply",
          "garden_points/garden_init.compressed.ply",
          "guitar/guitar.ply",
          "lego_house/lego_house_50k.ply",
          "lego_house/fourth_st.spz",
          "playbot/playbot_31k.ply",
          "ponytail_palm/ponytail_palm.ply",
          "statues/angel_statue_only.ply",
          "statues/angel-kneeling.sog",
          "statues/massa.sog",
          "statues/narcissus.sog",
          "statues/trumpet_statue_only.ply",
          "statues/angel.ply",
          "statues/trumpet.sog",
          "playbot/sog_lod2",
          "fur_block"};
}

// Stacks of limp bodies are chaotic: a gain of energy shows at some rates only.
std::vector<double> rates_of(TrialBody body, TrialAction action) {
  std::vector<double> rates = kRates_hz;
  if (body == TrialBody::Elastic && action == TrialAction::Stacked) {
    rates.insert(rates.end(), {66.0, 100.0, 120.0});
  }
  return rates;
}

class EveryCapture : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryCapture, StaysStableForTwentySeconds) {
  const fs::path path = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats" / GetParam();
  if (!fs::exists(path)) GTEST_SKIP() << "the shared data is missing";
  for (const TrialBody body : {TrialBody::Rigid, TrialBody::Elastic, TrialBody::Fragile}) {
    for (const TrialAction action :
         {TrialAction::Dropped, TrialAction::Thrown, TrialAction::Pulled, TrialAction::Stacked}) {
      for (const double rate_hz : rates_of(body, action)) {
        const AssetTrial trial = run_asset_trial(path.string(), body, action, 20.0, rate_hz);
        expect_nothing_exploded(trial);
        if (body == TrialBody::Fragile)
          EXPECT_TRUE(trial.broke) << "action " << static_cast<int>(action) << " at " << rate_hz;
        if (const char* csv = std::getenv("LIVEGS_TRIAL_CSV")) {
          const bool fresh = !fs::exists(csv);
          std::ofstream file(csv, std::ios::app);
          if (fresh) file << csv_header() << '\n';
          file << csv_row(trial) << std::endl;
        }
      }
    }
  }
}

std::string case_name(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = fs::path(info.param).stem().string();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Captured, EveryCapture, ::testing::ValuesIn(captures()), case_name);

}  // namespace
}  // namespace livegs::testing
