// SPDX-License-Identifier: Apache-2.0
// The reference of soft_depth_test: the same block in cells of 25, 12.5 and 6.25 mm, with the particle
// spacing of the finest.
#include "known_gaps.h"
#include "server/physics/soft/soft_depth.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

TEST(SoftDepth, DepthConvergesWithTheCells) {
  const double coarse_m = settled_depth_m(particle_block(0.00625, 0.025), 60.0);
  const double middle_m = settled_depth_m(particle_block(0.00625, 0.0125), 60.0);
  const double fine_m = settled_depth_m(particle_block(0.00625, 0.00625), 60.0);
  report_gap("soft.depth_convergence",
             std::abs(middle_m / fine_m - 1.0));  // the bar is a tenth of the bar of soft_depth_test
  // The reference of the chart and of accuracy_test, to a tenth of their bar of 10 %.
  EXPECT_NEAR(fine_m / 0.01444, 1.0, 0.01);
  EXPECT_LT(std::abs(middle_m - fine_m), 0.25 * std::abs(coarse_m - middle_m))
      << "not of second order in the width";
}

}  // namespace
}  // namespace livegs
