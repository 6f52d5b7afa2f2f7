// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/capture.h"

namespace livegs {

// Size of the scene, the unit of the learning rate of positions: 1.1 times the largest distance of a camera
// from the middle of all (Kerbl et al. 2023). Cameras farther than kFarCamera times the median distance are
// ignored, because one wrong pose would make every kernel move too fast. Above 0.
inline constexpr double kFarCamera = 4;
double robust_extent(const std::vector<CapturedView>& views);

}  // namespace livegs
