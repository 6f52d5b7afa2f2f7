// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/segment/segment_room.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "cli/output_path.h"
#include "cli/segment/segment_files.h"
#include "core/log.h"
#include "gaussian/opacity.h"
#include "parts/labelled_room.h"
#include "parts/views/choose_cameras.h"
#include "splat/image.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxCameraTilt_deg = 40;  // between the mean up axis of photos and an axis of the splat
constexpr double kMaxKnownLength_m = 1000;
// Kernels of less opacity do not count for the size of a thing: faint ones reach far beyond its surface.
constexpr float kSolidOpacity = 0.5f;

struct UpAxis {
  const char* name;
  Eigen::Vector3d axis;
};
const UpAxis kUpAxes[] = {{"-y", -Eigen::Vector3d::UnitY()}, {"y", Eigen::Vector3d::UnitY()},
                          {"z", Eigen::Vector3d::UnitZ()},   {"-z", -Eigen::Vector3d::UnitZ()},
                          {"x", Eigen::Vector3d::UnitX()},   {"-x", -Eigen::Vector3d::UnitX()}};

// The box of the solid kernels, without those that hang below the support of the thing.
Eigen::Vector3d size_of(const GaussianAsset& thing, const RoomParts& parts, const RoomPart& part) {
  const RoomPlane* support = part.support ? &parts.planes.supports[*part.support] : nullptr;
  Eigen::AlignedBox3d box;
  for (size_t k = 0; k < thing.size(); ++k) {
    const Eigen::Vector3d position = thing.positions[k].cast<double>();
    if (opacity_of_logit(thing.opacity_logits[k]) < kSolidOpacity) continue;
    if (support && support->height_m(position) < -parts.footprint_m) continue;
    box.extend(position);
  }
  if (box.isEmpty()) return Eigen::Vector3d::Zero();
  return box.sizes();
}

// The up axis: that of the option, else the mean up axis of the cameras, else that of 3DGS tools.
Result<UpAxis> choose_up(const std::string& wanted, const std::vector<Camera>& cameras) {
  if (!wanted.empty()) {
    for (const UpAxis& up : kUpAxes)
      if (wanted == up.name) return up;
    return invalid_argument("--up: \"" + wanted + "\" is not an axis; give one of x, -x, y, -y, z, -z");
  }
  if (cameras.empty()) return kUpAxes[0];
  const Eigen::Vector3d mean = mean_up(cameras);
  const UpAxis* best =
      std::max_element(std::begin(kUpAxes), std::end(kUpAxes),
                       [&](const UpAxis& a, const UpAxis& b) { return a.axis.dot(mean) < b.axis.dot(mean); });
  if (best->axis.dot(mean) < std::cos(kMaxCameraTilt_deg * M_PI / 180))
    return invalid_argument(
        "cameras: the mean up axis is not an axis of the splat; turn the splat or give --up");
  return *best;
}

// Reads the label pictures of a folder that have the name of a camera.
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
                     ": has no picture NAME.png with the name of a photo in the cameras file; name each mask "
                     "as its photo");
  return pictures;
}

std::string thing_name(size_t number) {
  char name[32];
  std::snprintf(name, sizeof name, "part_%02zu", number);
  return name;
}

}  // namespace

Result<KnownLength> read_known_length(const std::string& text) {
  KnownLength known;
  const char *begin = text.data(), *end = begin + text.size();
  if (text.starts_with("part_")) {
    const auto number = std::from_chars(begin + 5, end, known.thing);
    if (number.ec == std::errc() && known.thing > 0 && number.ptr != end && *number.ptr == '=') {
      const auto length = std::from_chars(number.ptr + 1, end, known.longest_side_m);
      if (length.ec == std::errc() && length.ptr == end && known.longest_side_m > 0 &&
          known.longest_side_m <= kMaxKnownLength_m)
        return known;
    }
  }
  return invalid_argument("--known: \"" + text +
                          "\" is not NAME=METRES with at most 1000 m; write part_03=0.21");
}

namespace {

// Part of the whole work that is done, for a fraction of a step of PartsOptions::progress. Drawing the views
// and labelling them take nearly all of the time, about half each.
double part_done(std::string_view step, double fraction) {
  if (step == "views") return 0.45 * fraction;
  if (step == "planes") return 0.45;
  if (step == "parts") return 0.5;
  return 0.5 + 0.45 * fraction;
}

}  // namespace

Result<void> check_segment_folder(const fs::path& output) {
  if (auto checked = check_output_folder(output); !checked) return checked;
  std::error_code error;
  for (fs::directory_iterator at(output, error), end; at != end; at.increment(error)) {
    if (at->path().filename() != kUnfinishedFolder)
      return invalid_argument(output.string() + ": exists and is not empty; give a new folder");
  }
  return {};
}

Result<SegmentOutcome> segment_room(GaussianAsset asset, const SegmentRequest& request) {
  SegmentedRoom room;
  PartsOptions options;
  for (const CapturedView& view : request.cameras) options.cameras.push_back(view.camera);
  auto up = choose_up(request.up, options.cameras);
  if (!up) return up.error();
  options.up = room.up = up->axis;
  room.up_axis = up->name;
  options.progress = [&request, last = std::string()](const char* step, double fraction) mutable {
    if (request.progress) request.progress(part_done(step, fraction));
    if (last != step) log_info("segment: %s", step);
    last = step;
  };
  room.original = std::move(asset);
  Result<RoomParts> found = Error{};
  if (!request.masks.empty()) {
    auto pictures = read_label_pictures(request.masks, request.cameras);
    if (!pictures) return pictures.error();
    found = lift_labels(room.original, std::move(*pictures), options);
  } else {
    found = find_parts(room.original, options);
  }
  if (!found) return Error{found.error().code, request.name + ": " + found.error().message};
  const Error nothing = invalid_data(
      request.name + ": has nothing that stands on a floor, a table or a wall; nothing was written");
  if (found->parts.empty()) return nothing;
  room.scale = request.scale;
  log_info("segment: borders");
  const LabelledRoom labelled = label_room(room.original, *found);
  std::vector<uint32_t> taken;
  for (const RoomPart& part : found->parts) {
    GaussianAsset thing = thing_alone(labelled, part.label);
    if (thing.size() == 0) {  // all of its kernels were cut off at the borders
      log_warn("segment: part %zu has no kernel of its own and stays in the room", size_t{part.label});
      continue;
    }
    taken.push_back(part.label);
    const bool filled = std::find(labelled.label.begin(), labelled.label.end(),
                                  label_of(KernelKind::Fill, part.label)) != labelled.label.end();
    const Eigen::Vector3d size = size_of(thing, *found, part);
    room.things.push_back({thing_name(part.label), std::move(thing), part, !filled, size});
  }
  if (room.things.empty()) return nothing;
  if (request.known) {
    const std::string name = thing_name(request.known->thing);
    const auto known = std::find_if(room.things.begin(), room.things.end(),
                                    [&](const SegmentedThing& thing) { return thing.name == name; });
    if (known == room.things.end())
      return invalid_argument("--known: " + name + " is not among the " + std::to_string(room.things.size()) +
                              " things that were found; give one of the parts that livegs segment wrote");
    if (!(known->size.maxCoeff() > 0))
      return invalid_argument("--known: " + name + " has no solid kernel; give another part");
    room.scale = request.known->longest_side_m / known->size.maxCoeff();
  }
  room.room = room_without(labelled, taken);
  room.parts = std::move(*found);
  const SegmentOutcome outcome{room.things.size(), room.scale};
  std::string lines;
  for (const SegmentedThing& thing : room.things) {
    const Eigen::Vector3d size = room.scale * thing.size;
    char line[200];
    std::snprintf(line, sizeof line, "%s: %zu kernels, %.3g x %.3g x %.3g m%s\n", thing.name.c_str(),
                  thing.asset.size(), size.x(), size.y(), size.z(),
                  thing.unfilled ? ", background not filled" : "");
    lines += line;
  }
  const fs::path output = fs::absolute(request.output / ".").lexically_normal().parent_path();
  if (auto written = write_segmented_room(output, std::move(room)); !written) return written.error();
  std::fputs(lines.c_str(), stdout);
  return outcome;
}

}  // namespace livegs
