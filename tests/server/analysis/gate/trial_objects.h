// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "analysis/knowledge/tables.h"
#include "server/analysis/gate/answer_fixtures.h"

namespace livegs {

// The six objects of a trial with a vision-language model (November 2026): what it answered, what was
// measured, and the true mass. `folder`: of the whole answer in reference/analysis-trial of the shared data.
struct TrialAnswer {
  const char *folder, *id, *name, *fill, *behaviour;
  bool replica;
  Span3 mass_g;
  std::vector<std::pair<const char*, double>> parts;  // material, share
  Eigen::Vector3d size_m, box_cm;
  double volume_cm3, area_cm2, solidity, openness, truth_g;
};

inline const std::vector<TrialAnswer>& trial_answers() {
  static const std::vector<TrialAnswer> all = {{"lemon",
                                                "thing11",
                                                "artificial lemon",
                                                "shell",
                                                "rigid",
                                                true,
                                                {15, 31, 102},
                                                {{"LDPE", 1}},
                                                {0.0605, 0.053, 0.0592},
                                                {5.97, 5.85, 5.27},
                                                96.71,
                                                103.5,
                                                0.99,
                                                0,
                                                29},
                                               {"baseball",
                                                "thing01",
                                                "baseball",
                                                "solid",
                                                "rigid",
                                                false,
                                                {134, 145, 152},
                                                {{"stitched ball", 1}},
                                                {0.073, 0.0725, 0.0735},
                                                {7.25, 7.24, 7.2},
                                                202.6,
                                                167.8,
                                                1,
                                                0,
                                                148},
                                               {"cup",
                                                "thing05",
                                                "toy stacking cup",
                                                "open_shell",
                                                "rigid",
                                                false,
                                                {8.5, 13.7, 24},
                                                {{"polypropylene", 1}},
                                                {0.0576, 0.0622, 0.0579},
                                                {6.22, 5.76, 5.74},
                                                27.66,
                                                208.7,
                                                0.22,
                                                0.67,
                                                14},
                                               {"fork",
                                                "thing09",
                                                "fork",
                                                "assembly",
                                                "rigid",
                                                false,
                                                {24, 35.5, 56},
                                                {{"stainless steel", 0.71}, {"polypropylene", 0.29}},
                                                {0.197, 0.0153, 0.0268},
                                                {19.7, 2.51, 1.53},
                                                20.2,
                                                87.1,
                                                0.49,
                                                0,
                                                34},
                                               {"screwdriver",
                                                "thing16",
                                                "screwdriver",
                                                "assembly",
                                                "rigid",
                                                false,
                                                {70, 98, 145},
                                                {{"carbon steel", 0.31}, {"polypropylene", 0.69}},
                                                {0.194, 0.0354, 0.106},
                                                {21.6, 3.39, 3.38},
                                                77.57,
                                                129.9,
                                                0.7,
                                                0,
                                                97},
                                               {"airplane",
                                                "thing10",
                                                "toy airplane",
                                                "assembly",
                                                "rigid",
                                                false,
                                                {260, 505, 780},
                                                {{"ABS", 0.85}, {"polypropylene", 0.15}},
                                                {0.255, 0.182, 0.262},
                                                {26.5, 25.4, 17.6},
                                                1748,
                                                1826,
                                                0.28,
                                                0.21,
                                                570}};
  return all;
}

inline ObjectFacts trial_facts(const TrialAnswer& one) {
  const double volume_m3 = 1e-6 * one.volume_cm3, area_m2 = 1e-4 * one.area_cm2;
  return facts_of(one.id, {.size_m = one.size_m,
                           .box_m = 1e-2 * one.box_cm,
                           .principal_size_m = 1e-2 * one.box_cm,
                           .volume_m3 = volume_m3,
                           .area_m2 = area_m2,
                           .mean_wall_m = 2 * volume_m3 / area_m2,
                           .hull_volume_m3 = volume_m3 / one.solidity,
                           .solidity = one.solidity,
                           .openness = one.openness});
}

}  // namespace livegs
