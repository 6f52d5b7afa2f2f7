// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parts/click/kernel_graph.h"

namespace livegs {

struct Click {
  uint32_t kernel = 0;  // that the ray of a user meets (kernel_on_ray.h)
  bool take = true;     // false: it does not belong to the thing
};

struct CutThing {
  std::vector<uint32_t> kernels;  // ascending; empty if no click takes from a part
  size_t nodes = 0;               // of the graph that was cut
};

// The kernels that some clicks take out of a room, by a minimum cut (Boykov and Kolmogorov 2004). `label` has
// the part of each kernel, 0 for the room. Clicks fix the kernels around them. The labels are evidence: parts
// on which clicks take are wanted, and only kernels near their borders are nodes of the graph. A click that
// takes next to a wanted part corrects its border: around it labels are no evidence. A part on which clicks
// take and take away is divided: all its kernels are nodes, and its label is evidence of at most what the
// edges around the clicks that take away are worth, so that these separate the part at a line of weaker edges
// if there is one, and only their surroundings if there is none. Any thread; deterministic.
CutThing cut_thing(const KernelGraph& graph, std::span<const uint16_t> label, std::span<const Click> clicks);

}  // namespace livegs
