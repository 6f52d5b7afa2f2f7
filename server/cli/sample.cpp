// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/output_path.h"
#include "core/file.h"
#include "core/log.h"
#include "gaussian/asset_file.h"
#include "sample/sample_scene.h"

namespace livegs {
namespace {

// Initial poses of the sample assets: above the floor, so that the scene moves at once.
constexpr const char* kSceneFile = R"({
  "rate_hz": 90,
  "substeps": 4,
  "environment": {
    "asset": "room.ply",
    "colliders": [ { "plane": { "point_m": [0, 0, 0],    "normal": [0, 1, 0] }, "friction": 0.6, "restitution": 0.2 },
                   { "plane": { "point_m": [0, 0, -1.5], "normal": [0, 0, 1] }, "friction": 0.5, "restitution": 0.3 },
                   { "plane": { "point_m": [-1.5, 0, 0], "normal": [1, 0, 0] }, "friction": 0.5, "restitution": 0.3 } ]
  },
  "objects": [
    { "name": "stool",  "asset": "stool.ply",  "scale": 1, "pose": { "position_m": [-0.62, 0.02, -0.45] } },
    { "name": "plant",  "asset": "plant.ply",  "scale": 1, "spacing_m": 0.03, "pose": { "position_m": [ 0.72, 0.04, -0.55] } },
    { "name": "pillow", "asset": "pillow.ply", "scale": 1, "pose": { "position_m": [-0.02, 0.40, -0.30] } },
    { "name": "hat",    "asset": "hat.ply",    "scale": 1, "spacing_m": 0.014, "pose": { "position_m": [-0.42, 0.30,  0.12] } },
    { "name": "cup",    "asset": "cup.ply",    "scale": 1, "pose": { "position_m": [ 0.42, 0.90,  0.15] } },
    { "name": "duck",   "asset": "duck.ply",   "scale": 1, "pose": { "position_m": [ 0.05, 0.05,  0.30] } }
  ]
}
)";

int write_sample(const std::filesystem::path& folder, uint64_t seed) {
  if (auto checked = check_output_folder(folder); !checked) return report(checked.error());
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return report({ErrorCode::PermissionDenied,
                   folder.string() + ": cannot be created: " + error.message() + "; give another folder"});
  for (const SampleAsset& sample : make_sample_assets(seed)) {
    const auto path = folder / (sample.name + ".ply");
    if (auto written = write_asset(path, sample.asset); !written) return report(written.error());
    std::printf("%-28s %6zu kernels, SH degree %d\n", path.c_str(), sample.asset.size(),
                sample.asset.sh_degree);
  }
  const auto scene = folder / "sample.scene.json";
  if (auto written = write_file_atomically(scene, kSceneFile); !written) return report(written.error());
  std::printf("%s\n", scene.c_str());
  return 0;
}

}  // namespace

void add_sample(CLI::App& app, int& exit_code) {
  struct Options {
    std::filesystem::path folder;
    uint64_t seed = 1;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("sample", "Generate the sample scene: six objects and a room");
  command->add_option("DIR", options->folder, "Output folder, created if it does not exist")->required();
  command->add_option("--seed", options->seed, "Seed of the random details")->capture_default_str();
  command->callback([options, &exit_code] { exit_code = write_sample(options->folder, options->seed); });
}

}  // namespace livegs
