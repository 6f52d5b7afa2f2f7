// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>

#include "core/text/path_ending.h"
#include "gaussian/asset_name.h"
#include "gaussian/read_options.h"

namespace livegs {

// Whether a path names a scene: a scene file, or a folder that is not an unpacked asset.
inline bool is_scene_input(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return !asset_index(path);
  return has_ending(path.string(), ".scene.json");
}

inline void add_activated_flag(CLI::App& command, bool& activated) {
  command.add_flag("--activated", activated,
                   "The .ply stores standard deviations and opacities, not logarithms and logits");
}

inline ReadOptions read_options(bool activated) {
  return {activated ? ReadOptions::Activated::Yes : ReadOptions::Activated::Auto};
}

}  // namespace livegs
