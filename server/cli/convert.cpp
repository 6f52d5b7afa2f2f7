// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/input_kind.h"
#include "cli/output_path.h"
#include "gaussian/asset_file.h"
#include "gaussian/transform_asset.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

struct ConvertCommand {
  std::filesystem::path from, to;
  std::string up;
  double scale = 1;
  bool metric = false, with_origin = false, activated = false;
};

// Turns the asset to -y up, the axis of assets, and scales it; the frame follows.
Result<void> turn_and_scale(const ConvertCommand& options, AssetFile& file) {
  const std::string up = options.up.empty() ? file.frame.up_axis : options.up;
  const auto y_up = up_value(up, "--up");
  if (!y_up) return y_up.error();
  double scale = options.scale;
  if (file.frame.metres_per_unit > 0) {
    // These are in metres.
    const std::string to = options.to.string();
    if ((has_ending(to, ".spz") || has_ending(to, ".glb")) && scale == 1) scale = file.frame.metres_per_unit;
    file.frame.metres_per_unit /= scale;
  }
  if (!up.empty() || scale != 1) {
    const Eigen::Quaterniond turn = up_value("-y", "--up")->conjugate() * *y_up;
    if (up != "-y" || scale != 1) transform_asset(file.asset, turn, scale);
    file.frame.origin = scale * (turn * file.frame.origin);
  }
  if (!up.empty()) file.frame.up_axis = "-y";
  if (options.metric) file.frame.metres_per_unit = 1;
  return {};
}

int run(const ConvertCommand& options) {
  if (auto checked = check_output_file(options.to, {".ply", ".spz", ".sog", ".splat", ".glb"}); !checked)
    return report(checked.error());
  if (!(options.scale > 0) || !std::isfinite(options.scale))
    return report(invalid_argument("--scale: must be a number above 0"));
  if (const auto up = up_value(options.up, "--up"); !up) return report(up.error());
  auto file = read_asset(options.from, read_options(options.activated));
  if (!file) return report(file.error());
  for (const std::string& note : file->notes)
    std::fprintf(stderr, "%s: %s\n", options.from.c_str(), note.c_str());
  if (auto turned = turn_and_scale(options, *file); !turned) return report(turned.error());
  WriteOptions write;
  write.with_origin = options.with_origin;
  for (const std::string& loss : losses_of_format(options.to.string(), file->asset, file->frame, write))
    std::fprintf(stderr, "%s: %s\n", options.to.c_str(), loss.c_str());
  if (auto written = write_asset(options.to, file->asset, file->frame, write); !written)
    return report(written.error());
  std::printf("%s: %zu kernels, SH degree %d\n", options.to.c_str(), file->asset.size(),
              file->asset.sh_degree);
  return 0;
}

}  // namespace

void add_convert(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ConvertCommand>();
  CLI::App* command = app.add_subcommand("convert", "Convert a splat asset to another format");
  command
      ->add_option(
          "FROM", options->from,
          "Input: a .ply, .compressed.ply, .spz, .sog, .splat, .glb or .gltf file, or the folder of an "
          "unpacked or streamed .sog")
      ->required()
      ->type_name("");
  command->add_option("TO", options->to, "Output: a .ply, .compressed.ply, .spz, .sog, .splat or .glb file")
      ->required()
      ->type_name("");
  command
      ->add_option("--up", options->up,
                   "Up axis of the input, one of x, -x, y, -y, z, -z; it becomes -y, the up axis of assets")
      ->type_name("AXIS")
      ->default_str("that of the file, else -y");
  command->add_option("--scale", options->scale, "Factor on all sizes and positions")
      ->type_name("FACTOR")
      ->capture_default_str();
  command->add_flag("--metric", options->metric,
                    "Mark the result as metric; without this option, an unknown unit stays unknown");
  command->add_flag("--with-origin", options->with_origin,
                    "Add the origin that was subtracted, and write positions as doubles (.ply)");
  add_activated_flag(*command, options->activated);
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
