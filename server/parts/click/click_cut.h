// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parts/click/kernel_graph.h"

namespace livegs {

struct Click {
  uint32_t kernel = 0;  // hit by the ray of a user (kernel_on_ray.h)
  bool take = true;     // false: it does not belong to the thing
};

struct CutThing {
  std::vector<uint32_t> kernels;  // ascending; empty if no taking click hits a part
  size_t nodes = 0;               // of the graph that was cut
};

// Selects the kernels that clicks take out of a room, by a minimum cut (Boykov and Kolmogorov 2004). `label`
// has the part of each kernel, 0 for the room. Clicks fix the labels of the kernels around them. Other labels
// are evidence. A part with a taking click is selected, and only kernels near its border are nodes of the
// graph. A taking click next to a selected part corrects its border, so the labels around the click are
// ignored. A part with both kinds of clicks is divided, and all its kernels are nodes. The evidence of its
// label is limited to the weight of the edges around the rejecting clicks. These clicks then separate the
// part at a line of weak edges if there is one, and otherwise only their surroundings. Any thread;
// deterministic.
CutThing cut_thing(const KernelGraph& graph, std::span<const uint16_t> label, std::span<const Click> clicks);

}  // namespace livegs
