// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "compute/vulkan_device.h"
#include "core/result.h"

namespace livegs::gpu_report {

// A tick of elastic bodies on the device, with the upload and the read-back of their state.
struct PhysicsRow {
  size_t bodies = 1, nodes = 0;         // of all bodies
  int steps = 0, ticks = 0;             // steps of a tick; ticks measured
  double tick_ms = 0, tick_max_ms = 0;  // by the host's clock: median and maximum
  double dispatches = 0, submissions = 0, barriers = 0, uploaded_bytes = 0;  // a tick
  double bytes_a_node_step = 0;  // that the passes have to read and write
};

// Cubes of full cells: one of about each number of `nodes`, then many bodies of a thousand nodes that are as
// many nodes together. Nothing touches. Calls `measured` after each row. A number that the device cannot
// hold is skipped, with a line on standard error.
Result<void> measure_physics(const std::shared_ptr<VulkanDevice>& device, const std::vector<size_t>& nodes,
                             const std::function<void(const PhysicsRow&)>& measured);

std::string physics_csv(const std::string& device, const std::vector<PhysicsRow>& rows);
// The section of report.md. Without times for a software device.
std::string physics_text(const std::vector<PhysicsRow>& rows, bool software);

}  // namespace livegs::gpu_report
