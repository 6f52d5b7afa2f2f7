// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Checks the invariants of gaussian_asset.h, which every reader must establish.
inline void expect_invariants(const GaussianAsset& asset, const std::string& what) {
  const size_t count = asset.size();
  ASSERT_GT(count, 0u) << what;
  ASSERT_TRUE(asset.sh_degree >= 0 && asset.sh_degree <= 3) << what;
  ASSERT_EQ(asset.log_scales.size(), count) << what;
  ASSERT_EQ(asset.rotations.size(), count) << what;
  ASSERT_EQ(asset.opacity_logits.size(), count) << what;
  ASSERT_EQ(asset.sh_dc.size(), count) << what;
  ASSERT_EQ(asset.sh_rest.size(), count * asset.sh_rest_count()) << what;
  bool finite = true, unit = true;
  for (size_t i = 0; i < count; ++i) {
    finite &= asset.positions[i].allFinite() && asset.log_scales[i].allFinite() &&
              asset.sh_dc[i].allFinite() && std::isfinite(asset.opacity_logits[i]);
    unit &= std::abs(asset.rotations[i].cast<double>().squaredNorm() - 1) <
            1.1e-6;  // kUnitTolerance and rounding
  }
  for (const Eigen::Vector3f& coefficient : asset.sh_rest) finite &= coefficient.allFinite();
  EXPECT_TRUE(finite) << what;
  EXPECT_TRUE(unit) << what;
}

}  // namespace livegs
