// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "compute/backend.h"
#include "core/result.h"

namespace livegs {

// Adds --device to a command; `choice` is auto, cpu or vulkan.
void add_device_option(CLI::App& command, std::string& choice);

// A backend on a Vulkan device, or null for the CPU: auto takes a GPU if there is one, but no software
// device. Logs which. Unavailable if vulkan is wanted and there is no device.
Result<std::unique_ptr<Backend>> choose_device(const std::string& choice);

}  // namespace livegs
