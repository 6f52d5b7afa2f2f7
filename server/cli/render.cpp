// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <memory>
#include <numbers>

#include "cli/choose_device.h"
#include "cli/commands.h"
#include "cli/input_kind.h"
#include "cli/output_path.h"
#include "core/clock.h"
#include "core/file.h"
#include "scene/build/place_asset.h"
#include "scene/views/scene_drawing.h"
#include "splat/camera_file.h"
#include "splat/frame_bounds.h"
#include "splat/tiles/image_rasteriser.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

struct RenderCommand {
  std::filesystem::path input, output = "render.png", camera, frame;
  std::string up;
  int width = 640, height = 480;
  double azimuth_deg = 0, elevation_deg = kDefaultElevation_rad * 180 / std::numbers::pi;
  int turns = 1;
  std::vector<double> background;  // empty: that of the scene, else kPictureBackground
  bool no_shadows = false, activated = false;
  std::string device = "auto";
};

Camera camera_at(const RenderCommand& options, std::span<const Eigen::AlignedBox3d> boxes, int turn) {
  const double azimuth = options.azimuth_deg + 360.0 * turn / options.turns;
  return frame_boxes(boxes, options.width, options.height, azimuth * std::numbers::pi / 180,
                     options.elevation_deg * std::numbers::pi / 180);
}

std::filesystem::path numbered(const std::filesystem::path& output, int turn, int turns) {
  if (turns == 1) return output;
  char number[16];
  std::snprintf(number, sizeof number, "_%03d", turn);
  return output.parent_path() / (output.stem().string() + number + output.extension().string());
}

int draw(const RenderCommand& options, std::span<const DrawnObject> objects,
         std::span<const Eigen::AlignedBox3d> boxes, RasteriseOptions rasterise = {}) {
  const auto& rgb = options.background;
  if (rgb.size() == 3) rasterise.background = Eigen::Vector3d(rgb[0], rgb[1], rgb[2]).cast<float>();
  auto device = choose_device(options.device);
  if (!device) return report(device.error());
  ImageRasteriser rasteriser(*std::move(device));
  Image image;
  for (int turn = 0; turn < options.turns; ++turn) {
    Camera camera = camera_at(options, boxes, turn);
    if (!options.camera.empty()) {
      auto read = read_camera_file(options.camera);
      if (!read) return report(read.error());
      camera = *read;
    }
    const int64_t begun_ns = now_ns();
    rasteriser.draw(objects, camera, rasterise, image);
    const double drawn_ms = milliseconds_from_ns(now_ns() - begun_ns);
    const auto path = numbered(options.output, turn, options.turns);
    if (auto written = write_png(path, image); !written) return report(written.error());
    std::printf("%s: %zu kernels in view, %.1f ms\n", path.c_str(), rasteriser.visible_kernels(), drawn_ms);
  }
  return 0;
}

// Draws an asset by itself, as a scene with one static object.
int render_asset(const RenderCommand& options) {
  auto placed = place_asset(options.input, "", 1.0, options.up, "render", std::nullopt,
                            read_options(options.activated));
  if (!placed) return report(placed.error());
  RestBody rest;
  rest.object_from_asset = placed->object_from_asset;
  rest.bodies = {Pose{}};
  auto bindings = bind_kernels(*placed->asset, rest);
  if (!bindings) return report(bindings.error());
  ObjectDrivers drivers;
  drivers.poses = {Pose{}};
  PosedKernels kernels;
  skin_kernels(*placed->asset, rest, *bindings, drivers, kernels);
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& point : placed->body_points_m) bounds.extend(point);
  const DrawnObject object{placed->asset.get(), &kernels, 0};
  RasteriseOptions rasterise;
  rasterise.background = kPictureBackground;
  return draw(options, std::span(&object, 1), std::span(&bounds, 1), rasterise);
}

int render_scene(const RenderCommand& options) {
  auto scene = Scene::load(options.input, {});
  if (!scene) return report(scene.error());
  DriverFrame frame;
  if (!options.frame.empty()) {
    auto bytes = read_file(options.frame);
    if (!bytes) return report(bytes.error());
    auto decoded = decode_frame(*bytes);
    if (!decoded)
      return report(
          {decoded.error().code, options.frame.filename().string() + ": " + decoded.error().message});
    frame = std::move(*decoded);
  }
  SceneDrawing drawing;
  drawing.set_shadows(!options.no_shadows);
  auto drawn = drawing.pose(*scene, options.frame.empty() ? nullptr : &frame);
  if (!drawn) return report(drawn.error());
  return draw(options, *drawn, drawing.object_boxes(), drawing.options());
}

int run(const RenderCommand& options) {
  if (auto checked = check_output_file(options.output, {".png"}); !checked) return report(checked.error());
  const bool scene = is_scene_input(options.input);
  if (!scene && !options.frame.empty())
    return report(invalid_argument("--frame: does not apply to a single asset; give a scene file or folder"));
  return scene ? render_scene(options) : render_asset(options);
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RenderCommand>();
  CLI::App* command = app.add_subcommand("render", "Render an asset or the initial state of a scene to PNG");
  command->add_option("INPUT", options->input, "Splat asset, *.scene.json or folder of assets")->required();
  command->add_option("--output,-o", options->output, "Output PNG file")
      ->type_name("FILE")
      ->capture_default_str();
  command->add_option("--camera", options->camera, "Camera file (default: everything, from the front)")
      ->type_name("FILE");
  command->add_option("--frame", options->frame, "Pose the scene with this recorded driver frame")
      ->type_name("FILE");
  command->add_option("--up", options->up, "Up axis of the asset, one of x, -x, y, -y, z, -z")
      ->type_name("AXIS")
      ->default_str("that of the file, else -y");
  add_activated_flag(*command, options->activated);
  command->add_option("--width", options->width, "Width of the picture in pixels")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  command->add_option("--height", options->height, "Height of the picture in pixels")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  add_device_option(*command, options->device);
  command->add_option("--azimuth", options->azimuth_deg, "Azimuth of the camera in degrees, to the right")
      ->type_name("DEGREES")
      ->capture_default_str();
  command
      ->add_option("--elevation", options->elevation_deg,
                   "Elevation of the camera in degrees above the horizon")
      ->type_name("DEGREES")
      ->check(CLI::Range(-89.0, 89.0))
      ->capture_default_str();
  command->add_option("--turns", options->turns, "Number of pictures around the object, with numbered files")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  command
      ->add_option("--background", options->background,
                   "Background colour: red, green, blue, 0 to 1 (default: that of the scene, else dark)")
      ->type_name("R G B")
      ->expected(3);
  command->add_flag("--no-shadows", options->no_shadows,
                    "Draw the objects of a scene without contact and soft shadows");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
