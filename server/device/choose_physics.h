// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "physics/elastic_device.h"

namespace livegs {

// Values of the option --physics.
inline const std::vector<std::string> kPhysicsChoices = {"auto", "cpu", "vulkan"};
inline constexpr const char* kPhysicsHelp =
    "Device that steps isolated elastic bodies: auto (the CPU or a GPU, by predicted time), cpu, or vulkan "
    "(also a software device)";

// Chooses the device that steps elastic bodies, for set_elastic_device:
//   cpu     null
//   vulkan  on the best Vulkan device, also a software one; Unavailable, with the remedy, if there is none
//   auto    null without a GPU; with one, each tick runs on the device if its predicted cost is lower
//           (elastic_cost.h; the model is stored in the user's cache folder)
// Logs the choice in one line.
Result<std::shared_ptr<ElasticDevice>> choose_physics(const std::string& choice);

}  // namespace livegs
