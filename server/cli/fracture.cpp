// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>
#include <filesystem>
#include <memory>
#include <numbers>

#include "cli/commands.h"
#include "cli/output_path.h"
#include "gaussian/asset_name.h"
#include "geometry/fracture/fracture_seeds.h"
#include "geometry/fracture/piece_kernels.h"
#include "geometry/fracture/voronoi_pieces.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/reconstruct_surface.h"
#include "scene/build/place_asset.h"
#include "skin/skin_kernels.h"
#include "splat/frame_bounds.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

struct FractureCommand {
  std::filesystem::path asset, output;
  double scale = 0;
  std::string up;
  size_t pieces = 16;
  uint64_t seed = 1;
  std::vector<double> impact_m;
  bool coarse = false;
  double apart = 0.35;
  int width = 960, height = 720;
  double azimuth_deg = 20, elevation_deg = 20;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Moves the kernels of each piece away from `middle` by `apart` times the distance of the piece.
PosedKernels posed(const PieceKernels& kernels, const Similarity& object_from_asset,
                   const VoronoiPieces& pieces, double apart, const Eigen::Vector3d& middle) {
  RestBody rest;
  rest.object_from_asset = object_from_asset;
  rest.bodies = {Pose{}};
  ObjectDrivers drivers;
  drivers.poses = {Pose{}};
  PosedKernels out;
  const auto bindings = bind_kernels(kernels.asset, rest);
  if (!bindings) return out;
  skin_kernels(kernels.asset, rest, *bindings, drivers, out);
  for (size_t k = 0; k < out.positions_m.size(); ++k) {
    const Eigen::Vector3d& centre = pieces.pieces[kernels.piece[k]].mass.centre_of_mass_m;
    out.positions_m[k] += (apart * (centre - middle)).cast<float>();
  }
  return out;
}

// Returns a colour for each piece. Consecutive hues differ by the golden angle.
Eigen::Vector3f piece_colour(uint32_t piece) {
  const double hue = 2.399963 * piece;
  const Eigen::Array3d rgb = 0.55 + 0.35 * (Eigen::Array3d(0, 2.0944, 4.1888) + hue).cos();
  return ((rgb - 0.5) / 0.28209479).matrix().cast<float>();
}

Result<void> draw(const GaussianAsset& asset, const PosedKernels& kernels, const Camera& camera,
                  const std::filesystem::path& path) {
  RasteriseOptions options;
  options.background = {0.08f, 0.08f, 0.1f};
  Rasteriser rasteriser;
  RasterisedView view;
  const DrawnObject object{&asset, &kernels, 0};
  rasteriser.draw(std::span(&object, 1), camera, options, view);
  return write_png(path, view.image);
}

int run(const FractureCommand& options) {
  if (auto checked = check_output_folder(options.output); !checked) return report(checked.error());
  auto placed =
      place_asset(options.asset, asset_stem(options.asset).filename().string(),
                  options.scale > 0 ? std::optional(options.scale) : std::nullopt, options.up, "fracture");
  if (!placed) return report(placed.error());
  auto surface = reconstruct_surface(placed->body_points_m,
                                     options.coarse ? rigid_surface_options() : elastic_surface_options());
  if (!surface) return report(surface.error());

  SeedOptions seed_options;
  seed_options.count = options.pieces;
  seed_options.seed = options.seed;
  Eigen::Vector3d impact = Eigen::Vector3d::Zero();
  if (!options.impact_m.empty()) {
    impact = {options.impact_m[0], options.impact_m[1], options.impact_m[2]};
    seed_options.impacts_m = std::span(&impact, 1);
  }
  auto start = std::chrono::steady_clock::now();
  auto seeds = fracture_seeds(surface->mesh, seed_options);
  if (!seeds) return report(seeds.error());
  auto cut = cut_voronoi_pieces(surface->mesh, *seeds);
  if (!cut) return report(cut.error());
  const double cut_s = seconds_since(start);
  start = std::chrono::steady_clock::now();
  auto kernels = make_piece_kernels(*placed->asset, placed->object_from_asset, *cut);
  if (!kernels) return report(kernels.error());
  const double split_s = seconds_since(start);

  double volume_m3 = 0.0, area_m2 = 0.0;
  for (const VoronoiPiece& piece : cut->pieces) volume_m3 += piece.mass.volume_m3;
  for (const VoronoiBond& bond : cut->bonds) area_m2 += bond.area_m2;
  const double whole_m3 = signed_volume_m3(surface->mesh);
  std::printf("surface      %zu triangles, %.6g m3\n", surface->mesh.triangles.size(), whole_m3);
  std::printf("pieces       %zu from %zu seeds, %.6g m3 (the whole has %.6g m3), in %.3f s\n",
              cut->pieces.size(), seeds->size(), volume_m3, whole_m3, cut_s);
  std::printf("bonds        %zu, %.6g m2\n", cut->bonds.size(), area_m2);
  std::printf("kernels      %zu: %zu cut, %zu parts added, %zu on cut faces, in %.3f s\n",
              kernels->asset.size(), kernels->changed.size(),
              kernels->interior_begin - kernels->original_count,
              kernels->asset.size() - kernels->interior_begin, split_s);
  if (options.output.empty()) return 0;

  std::error_code made;
  std::filesystem::create_directories(options.output, made);
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(surface->mesh);
  Eigen::AlignedBox3d wide = bounds;
  for (const VoronoiPiece& piece : cut->pieces) {
    const Eigen::Vector3d way = options.apart * (piece.mass.centre_of_mass_m - bounds.center());
    for (const auto& vertex : piece.mesh.vertices_m) wide.extend(vertex + way);
  }
  const double degree = std::numbers::pi / 180;
  const Camera camera = frame_bounds(wide, options.width, options.height, options.azimuth_deg * degree,
                                     options.elevation_deg * degree);
  const Similarity& placement = placed->object_from_asset;
  GaussianAsset coloured = kernels->asset;
  coloured.sh_rest.assign(coloured.sh_rest.size(), Eigen::Vector3f::Zero());
  for (size_t k = 0; k < coloured.size(); ++k) coloured.sh_dc[k] = piece_colour(kernels->piece[k]);
  const PosedKernels whole = posed(*kernels, placement, *cut, 0.0, bounds.center());
  const PosedKernels apart = posed(*kernels, placement, *cut, options.apart, bounds.center());
  for (const auto& [asset, pose, name] :
       {std::tuple(&kernels->asset, &whole, "whole.png"), std::tuple(&kernels->asset, &apart, "apart.png"),
        std::tuple(&coloured, &whole, "pieces_whole.png"),
        std::tuple(&coloured, &apart, "pieces_apart.png")}) {
    if (auto drawn = draw(*asset, *pose, camera, options.output / name); !drawn) return report(drawn.error());
    std::printf("written      %s\n", (options.output / name).c_str());
  }
  return 0;
}

}  // namespace

void add_fracture(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<FractureCommand>();
  CLI::App* command = app.add_subcommand("fracture", "Cut an asset into the pieces of its fracture");
  command->add_option("ASSET", options->asset, "Splat asset")->required();
  command
      ->add_option("--output", options->output, "Folder for pictures of the pieces, assembled and separated")
      ->type_name("FOLDER");
  command->add_option("--pieces", options->pieces, "Number of pieces")
      ->check(CLI::Range(size_t{1}, kMaxSeeds))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of the pieces")->capture_default_str();
  command->add_option("--impact", options->impact_m, "Point of impact: x y z in metres, +Y up")
      ->type_name("X Y Z")
      ->expected(3);
  command->add_flag("--coarse", options->coarse,
                    "Cut the coarse surface of a rigid body instead of the fine surface");
  command->add_option("--scale", options->scale, "Metres per unit of the asset (default: guessed)")
      ->type_name("METRES");
  command->add_option("--up", options->up, "Up axis of the asset, one of x, -x, y, -y, z, -z")
      ->type_name("AXIS")
      ->default_str("-y");
  command
      ->add_option("--apart", options->apart,
                   "Displacement of the pieces relative to their distance from the centre")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--width", options->width, "Width of the picture in pixels")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  command->add_option("--height", options->height, "Height of the picture in pixels")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  command->add_option("--azimuth", options->azimuth_deg, "Azimuth of the camera in degrees, to the right")
      ->type_name("DEGREES")
      ->capture_default_str();
  command
      ->add_option("--elevation", options->elevation_deg,
                   "Elevation of the camera in degrees above the horizon")
      ->type_name("DEGREES")
      ->check(CLI::Range(-89.0, 89.0))
      ->capture_default_str();
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
