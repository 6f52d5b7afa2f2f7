// SPDX-License-Identifier: GPL-3.0-or-later
// livegs export gltf and usd: a scene with its physics as one file for other programs.
#include "cli/export_scene.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "cli/output_path.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "export/collect_recording.h"
#include "export/collect_scene.h"
#include "export/gltf_scene.h"
#include "export/usda_scene.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct SceneExport {
  fs::path scene, output, recording;
  std::string format;
  bool spz = false;
};

// The file that is written: `output` itself, or NAME.gltf or NAME.usda in the folder `output`.
Result<fs::path> file_to_write(const SceneExport& options) {
  const bool gltf = options.format == "gltf";
  const std::string output = options.output.string();
  std::error_code failed;
  const bool of_format =
      gltf ? has_ending(output, ".gltf") || has_ending(output, ".glb") : has_ending(output, ".usda");
  if (of_format && !fs::is_directory(options.output, failed)) return options.output;
  if (!gltf && (has_ending(output, ".usd") || has_ending(output, ".usdc") || has_ending(output, ".usdz")))
    return invalid_argument(output + ": cannot be written as " + options.output.extension().string() +
                            "; use .usda, or a folder");
  if (auto checked = check_output_folder(options.output); !checked) return checked.error();
  std::string name = fs::absolute(options.scene).lexically_normal().filename().string();
  if (name.empty()) name = fs::absolute(options.scene).lexically_normal().parent_path().filename().string();
  if (has_ending(name, ".scene.json")) name.resize(name.size() - std::string(".scene.json").size());
  if (name.empty()) name = "scene";
  fs::create_directories(options.output, failed);
  if (failed)
    return invalid_argument(output + ": cannot be created: " + failed.message() + "; give another folder");
  return options.output / (name + (gltf ? ".gltf" : ".usda"));
}

Result<void> export_scene(const SceneExport& options) {
  if (options.spz && options.format != "gltf") return invalid_argument("--spz: is only for gltf; omit it");
  set_log_level(LogLevel::Warn);
  auto scene = collect_scene(options.scene);
  if (!scene) return scene.error();
  if (!options.recording.empty()) {
    if (auto added = collect_recording(options.recording, *scene); !added) return added;
  }
  for (const std::string& note : scene->notes) std::fprintf(stderr, "%s\n", note.c_str());
  const auto file = file_to_write(options);
  if (!file) return file.error();
  const auto written = options.format == "gltf" ? write_gltf_scene(*file, *scene, {options.spz})
                                                : write_usda_scene(*file, *scene);
  if (!written) return written.error();
  size_t kernels = 0;
  for (const PortableBody& body : scene->bodies) kernels += body.kernel_count;
  std::printf("scene  bodies: %zu, joints: %zu, kernels: %zu", scene->bodies.size(), scene->joints.size(),
              kernels);
  if (scene->animation)
    std::printf(", motion: %.3g s in %zu keys", scene->animation->times_s.back(),
                scene->animation->times_s.size());
  std::printf("\n");
  for (const fs::path& one : *written) {
    std::error_code ignored;
    std::printf("%s  %.1f kB\n", one.c_str(), static_cast<double>(fs::file_size(one, ignored)) * 1e-3);
  }
  return {};
}

void add_options(CLI::App& command, SceneExport& options, bool required, const char* output) {
  command.add_option("SCENE", options.scene, "A *.scene.json, or a folder of assets")->required(required);
  command.add_option("OUT", options.output, output)->required(required);
  command
      .add_option("--recording", options.recording,
                  "Recording (*.lvgrec) of this scene with its assets; the motion is written as an animation")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
}

void add_spz(CLI::App& command, SceneExport& options) {
  command.add_flag("--spz", options.spz, "Store splats as .spz: a tenth of the size, quantised (gltf only)");
}

}  // namespace

void add_export_scene(CLI::App& command, int& exit_code) {
  const auto run = [&exit_code](const SceneExport& options) {
    if (const auto done = export_scene(options); !done) exit_code = report(done.error());
  };
  const auto gltf = std::make_shared<SceneExport>(), usd = std::make_shared<SceneExport>(),
             any = std::make_shared<SceneExport>();
  gltf->format = "gltf";
  usd->format = "usd";
  CLI::App* one = command.add_subcommand("gltf", "Write a scene with its physics as glTF 2.0");
  add_options(*one, *gltf, true, "A .glb, a .gltf (with a .bin next to it), or a folder");
  add_spz(*one, *gltf);
  one->callback([gltf, run] { run(*gltf); });
  one = command.add_subcommand("usd", "Write a scene with its physics as OpenUSD text");
  add_options(*one, *usd, true, "A .usda, or a folder");
  one->callback([usd, run] { run(*usd); });

  add_options(command, *any, false, "File or folder to write");
  command.add_option("--format", any->format, "Format of OUT")->check(CLI::IsMember({"gltf", "usd"}));
  add_spz(command, *any);
  command.callback([any, run, &command, &exit_code] {
    if (!command.get_subcommands().empty()) return;
    if (any->scene.empty() || any->output.empty() || any->format.empty()) {
      exit_code = report(invalid_argument(
          "export: SCENE, OUT or --format is missing; give all three, or one of web, gltf and usd"));
      return;
    }
    run(*any);
  });
}

}  // namespace livegs
