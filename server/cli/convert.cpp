// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "gaussian/asset_file.h"

namespace livegs {

void add_convert(CLI::App& app, int& exit_code) {
  struct Options {
    std::filesystem::path from, to;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("convert", "Convert a splat asset to another format");
  command
      ->add_option("FROM", options->from,
                   "Input: a .ply, .compressed.ply, .spz, .sog or .splat file, or an unpacked .sog folder")
      ->required();
  command->add_option("TO", options->to, "Output: a .ply or .spz file")->required();
  command->callback([options, &exit_code] {
    auto file = read_asset(options->from);
    if (!file) return void(exit_code = report(file.error()));
    for (const std::string& note : file->notes)
      std::fprintf(stderr, "%s: %s\n", options->from.c_str(), note.c_str());
    if (auto written = write_asset(options->to, file->asset); !written)
      return void(exit_code = report(written.error()));
    std::printf("%s: %zu kernels, SH degree %d\n", options->to.c_str(), file->asset.size(),
                file->asset.sh_degree);
  });
}

}  // namespace livegs
