// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "core/parallel_for.h"

namespace livegs {

// Work of one tick: bodies, steps of the body with the most, nodes times steps.
struct ElasticWork {
  int bodies = 0, steps = 0;
  double node_steps = 0;
};

// Predicted time of a tick of elastic bodies: on the device a fixed time, a time for each step (its
// dispatches) and for each node in a step; on the CPU a time for each node in a step, on as many threads as
// there are bodies.
struct ElasticCost {
  double device_tick_ms = 0, device_step_ms = 0, device_node_step_ms = 0, cpu_node_step_ms = 0;

  double device_ms(const ElasticWork& work) const {
    return device_tick_ms + work.steps * device_step_ms + work.node_steps * device_node_step_ms;
  }
  double cpu_ms(const ElasticWork& work) const {
    return work.node_steps * cpu_node_step_ms / std::clamp(thread_count(), 1, std::max(1, work.bodies));
  }
};

}  // namespace livegs
