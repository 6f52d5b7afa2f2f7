// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/input_kind.h"
#include "cli/output_path.h"
#include "core/file.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/reconstruct_surface.h"
#include "scene/build/place_asset.h"

namespace livegs {
namespace {

struct MeshCommand {
  std::filesystem::path asset, output;
  double scale = 0;
  std::string up;
  bool rigid = false, activated = false;
};

std::string obj_text(const TriangleMesh& mesh) {
  std::string text = "# metres, +Y up\n";
  char line[128];
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", v.x(), v.y(), v.z());
    text += line;
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", a + 1, b + 1, c + 1);
    text += line;
  }
  return text;
}

int run(const MeshCommand& options) {
  if (!options.output.empty()) {
    if (auto checked = check_output_file(options.output, {".obj"}); !checked) return report(checked.error());
  }
  auto placed = place_asset(options.asset, asset_stem(options.asset).filename().string(),
                            options.scale > 0 ? std::optional(options.scale) : std::nullopt, options.up,
                            "mesh", std::nullopt, read_options(options.activated));
  if (!placed) return report(placed.error());
  auto surface = reconstruct_surface(placed->body_points_m,
                                     options.rigid ? rigid_surface_options() : elastic_surface_options());
  if (!surface) return report(surface.error());
  const MassProperties properties = solid_mass_properties(surface->mesh);
  std::printf("scale        %.6g (%s)\n", placed->object_from_asset.scale, placed->scale_reason.c_str());
  std::printf("points       %zu, sampled from %zu kernels\n", placed->body_points_m.size(),
              placed->asset->size());
  std::printf("surface      %zu vertices, %zu triangles, alpha radius %.4g m\n",
              surface->mesh.vertices_m.size(), surface->mesh.triangles.size(), surface->alpha_radius_m);
  std::printf("volume       %.6g m3, area %.6g m2\n", properties.volume_m3, properties.area_m2);
  if (!surface->note.empty()) std::printf("note         %s\n", surface->note.c_str());
  if (!options.output.empty()) {
    if (auto written = write_file_atomically(options.output, obj_text(surface->mesh)); !written) {
      return report(written.error());
    }
    std::printf("written      %s\n", options.output.c_str());
  }
  return 0;
}

}  // namespace

void add_mesh(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<MeshCommand>();
  CLI::App* command =
      app.add_subcommand("mesh", "Reconstruct the closed surface of an asset, as used for its body");
  command->add_option("ASSET", options->asset, "Splat asset")->required();
  command->add_option("--output", options->output, "Output .obj file")->type_name("FILE");
  command->add_option("--scale", options->scale, "Metres per unit of the asset (default: guessed)")
      ->type_name("METRES");
  command->add_option("--up", options->up, "Up axis of the asset, one of x, -x, y, -y, z, -z")
      ->type_name("AXIS")
      ->default_str("that of the file, else -y");
  add_activated_flag(*command, options->activated);
  command->add_flag("--rigid", options->rigid, "Reconstruct the coarse surface of a rigid body");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
