// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "capture/read/pose_files.h"
#include "cli/commands.h"
#include "cli/output_path.h"
#include "cli/segment_files.h"
#include "core/log.h"
#include "gaussian/asset_file.h"
#include "parts/labelled_room.h"
#include "parts/views/choose_cameras.h"
#include "scene/values/scene_values.h"
#include "splat/image.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxCameraTilt_deg = 40;  // between the mean up axis of photos and an axis of the splat

struct SegmentCommand {
  fs::path input, output, cameras, masks;
  std::string up;
  double scale = 1.0;
};

struct UpAxis {
  const char* name;
  Eigen::Vector3d axis;
};
const UpAxis kUpAxes[] = {{"-y", -Eigen::Vector3d::UnitY()}, {"y", Eigen::Vector3d::UnitY()},
                          {"z", Eigen::Vector3d::UnitZ()},   {"-z", -Eigen::Vector3d::UnitZ()},
                          {"x", Eigen::Vector3d::UnitX()},   {"-x", -Eigen::Vector3d::UnitX()}};

// The option, else the axis that the cameras have above them, else that of 3DGS tools.
Result<UpAxis> choose_up(const SegmentCommand& command, const std::vector<Camera>& cameras) {
  if (!command.up.empty()) {
    for (const UpAxis& up : kUpAxes)
      if (command.up == up.name) return up;
    return invalid_argument("--up: \"" + command.up + "\" is no axis; give one of x, -x, y, -y, z, -z");
  }
  if (cameras.empty()) return kUpAxes[0];
  const Eigen::Vector3d mean = mean_up(cameras);
  const UpAxis* best =
      std::max_element(std::begin(kUpAxes), std::end(kUpAxes),
                       [&](const UpAxis& a, const UpAxis& b) { return a.axis.dot(mean) < b.axis.dot(mean); });
  if (best->axis.dot(mean) < std::cos(kMaxCameraTilt_deg * M_PI / 180))
    return invalid_argument(
        "cameras: their mean up axis is no axis of the splat; turn the splat or give --up");
  return *best;
}

// The label pictures of a folder that have the name of a camera.
Result<std::vector<LabelPicture>> read_label_pictures(const fs::path& folder,
                                                      const std::vector<CapturedView>& cameras) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return not_found(folder.string() + ": is not a folder; give the folder of the label pictures");
  std::vector<LabelPicture> pictures;
  for (const CapturedView& view : cameras) {
    const fs::path path = folder / (fs::path(view.name).stem().string() + ".png");
    if (view.name.empty() || !fs::exists(path, error)) continue;
    const Camera& camera = view.camera;
    auto image = read_png(path);
    if (!image) return image.error();
    if (image->width != camera.width || image->height != camera.height)
      return invalid_data(path.filename().string() + ": has " + std::to_string(image->width) + " x " +
                          std::to_string(image->height) + " pixels, its camera " +
                          std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                          "; give masks of the size of the photos");
    LabelPicture picture{camera, std::vector<uint16_t>(static_cast<size_t>(image->width) * image->height)};
    for (size_t i = 0; i < picture.labels.size(); ++i)
      picture.labels[i] = static_cast<uint16_t>(std::lround(255.0f * image->pixels[4 * i]));
    pictures.push_back(std::move(picture));
  }
  if (pictures.empty())
    return not_found(folder.string() +
                     ": has no picture NAME.png with the name of a photo in the cameras file");
  return pictures;
}

int segment(const SegmentCommand& command) {
  if (auto checked = check_output_folder(command.output); !checked) return report(checked.error());
  std::error_code error;
  const fs::path output = fs::absolute(command.output / ".").lexically_normal().parent_path();
  if (fs::exists(output, error) && !fs::is_empty(output, error))
    return report(invalid_argument(command.output.string() + ": exists and is not empty; give a new folder"));
  if (!command.masks.empty() && command.cameras.empty())
    return report(invalid_argument("--masks: needs --cameras, the transforms.json of the photos"));
  auto file = read_asset(command.input);
  if (!file) return report(file.error());
  for (const std::string& note : file->notes)
    log_warn("%s: %s", command.input.filename().c_str(), note.c_str());
  std::vector<CapturedView> cameras;
  if (!command.cameras.empty()) {
    auto read = read_transforms_file(command.cameras);
    if (!read) return report(read.error());
    cameras = std::move(read->views);
  }
  SegmentedRoom room;
  PartsOptions options;
  for (const CapturedView& view : cameras) options.cameras.push_back(view.camera);
  auto up = choose_up(command, options.cameras);
  if (!up) return report(up.error());
  options.up = room.up = up->axis;
  room.up_axis = up->name;
  room.scale = command.scale;
  options.progress = [last = std::string()](const char* step, double) mutable {
    if (last != step) log_info("segment: %s", step);
    last = step;
  };
  room.original = std::move(file->asset);
  Result<RoomParts> found = Error{};
  if (!command.masks.empty()) {
    auto pictures = read_label_pictures(command.masks, cameras);
    if (!pictures) return report(pictures.error());
    found = lift_labels(room.original, std::move(*pictures), options);
  } else {
    found = find_parts(room.original, options);
  }
  if (!found)
    return report({found.error().code, command.input.filename().string() + ": " + found.error().message});
  if (found->parts.empty())
    return report(
        invalid_data(command.input.filename().string() +
                     ": has nothing that stands on a floor, a table or a wall; nothing was written"));
  log_info("segment: borders");
  const LabelledRoom labelled = label_room(room.original, *found);
  std::vector<uint32_t> taken;
  for (const RoomPart& part : found->parts) {
    taken.push_back(part.label);
    const bool filled = std::find(labelled.label.begin(), labelled.label.end(),
                                  label_of(KernelKind::Fill, part.label)) != labelled.label.end();
    char name[32];
    std::snprintf(name, sizeof name, "part_%02zu", taken.size());
    room.things.push_back({name, thing_alone(labelled, part.label), part, !filled});
  }
  room.room = room_without(labelled, taken);
  room.parts = std::move(*found);
  const size_t things = room.things.size();
  for (const SegmentedThing& thing : room.things) {
    const Eigen::Vector3d size = command.scale * thing.part.bounds_m.sizes();
    std::printf("%s: %zu kernels, %.3g x %.3g x %.3g m%s\n", thing.name.c_str(), thing.asset.size(), size.x(),
                size.y(), size.z(), thing.unfilled ? ", left open behind it" : "");
  }
  if (auto written = write_segmented_room(output, std::move(room)); !written) return report(written.error());
  std::printf("%s: %zu things; run livegs-server %s\n", command.output.c_str(), things,
              (command.output / "room.scene.json").c_str());
  return 0;
}

}  // namespace

void add_segment(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SegmentCommand>();
  CLI::App* command =
      app.add_subcommand("segment", "Find the things in the splat of a room and write each as an asset");
  command->add_option("ROOM", options->input, "Splat of a room")->required();
  command
      ->add_option("--output,-o", options->output,
                   "Output folder, new or empty: things, room, scene and page")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--cameras", options->cameras, "transforms.json of the photos (default: views are chosen)")
      ->type_name("FILE");
  command
      ->add_option("--masks", options->masks,
                   "Folder of 8-bit label pictures NAME.png of some photos; 0 is the room. Needs --cameras")
      ->type_name("DIR");
  command
      ->add_option("--up", options->up,
                   "Up axis of the splat, one of x, -x, y, -y, z, -z (default: of the cameras, else -y)")
      ->type_name("AXIS");
  command->add_option("--scale", options->scale, "Metres per unit of the splat")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  command->callback([options, &exit_code] { exit_code = segment(*options); });
}

}  // namespace livegs
