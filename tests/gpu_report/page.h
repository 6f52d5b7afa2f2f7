// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gpu_report/device_facts.h"
#include "gpu_report/parity.h"
#include "gpu_report/physics_times.h"
#include "gpu_report/times.h"

namespace livegs::gpu_report {

// The results of a run. Parts that did not run are empty.
struct Report {
  DeviceFacts device;
  std::optional<Parity> parity;
  std::optional<CopyBandwidth> copy;
  std::vector<TimesRow> times;
  std::vector<PhysicsRow> physics;
};

std::string device_csv(const DeviceFacts& device);
std::string parity_csv(const Parity& parity);
std::string times_csv(const Report& report);
// report.md: the verdict of parity, times with shares of bandwidth, goals and counts. For a software device
// only parity and counts.
std::string page(const Report& report);

}  // namespace livegs::gpu_report
