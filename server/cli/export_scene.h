// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

namespace livegs {

// Adds `gltf` and `usd` to `livegs export`, and the same as `livegs export SCENE DIR --format gltf|usd`.
void add_export_scene(CLI::App& command, int& exit_code);

}  // namespace livegs
