// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace livegs {

// A material point as nodes and weights.
struct NodeSample {
  uint32_t nodes[8];
  float weights[8];
};

}  // namespace livegs
