// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/output_path.h"
#include "gaussian/asset_file.h"
#include "scene/values/scene_values.h"
#include "splat/transform_asset.h"

namespace livegs {
namespace {

struct ConvertCommand {
  std::filesystem::path from, to;
  std::string up;
  double scale = 1;
};

int run(const ConvertCommand& options) {
  if (auto checked = check_output_file(options.to, {".ply", ".spz"}); !checked)
    return report(checked.error());
  if (!(options.scale > 0) || !std::isfinite(options.scale))
    return report(invalid_argument("--scale: must be a number above 0"));
  const auto y_up = up_value(options.up, "--up");
  if (!y_up) return report(y_up.error());
  auto file = read_asset(options.from);
  if (!file) return report(file.error());
  for (const std::string& note : file->notes)
    std::fprintf(stderr, "%s: %s\n", options.from.c_str(), note.c_str());
  if (!options.up.empty() || options.scale != 1) {
    // Assets are -Y up, the default.
    transform_asset(file->asset, up_value("-y", "--up")->conjugate() * *y_up, options.scale);
  }
  if (auto written = write_asset(options.to, file->asset); !written) return report(written.error());
  std::printf("%s: %zu kernels, SH degree %d\n", options.to.c_str(), file->asset.size(),
              file->asset.sh_degree);
  return 0;
}

}  // namespace

void add_convert(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ConvertCommand>();
  CLI::App* command = app.add_subcommand("convert", "Convert a splat asset to another format");
  command
      ->add_option("FROM", options->from,
                   "Input: a .ply, .compressed.ply, .spz, .sog or .splat file, or an unpacked .sog folder")
      ->required()
      ->type_name("");
  command->add_option("TO", options->to, "Output: a .ply or .spz file")->required()->type_name("");
  command
      ->add_option("--up", options->up,
                   "Up axis of the input, one of x, -x, y, -y, z, -z; it becomes -y, the up axis of assets")
      ->type_name("AXIS")
      ->default_str("-y");
  command->add_option("--scale", options->scale, "Factor of all sizes and positions")
      ->type_name("FACTOR")
      ->capture_default_str();
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
