// SPDX-License-Identifier: GPL-3.0-or-later
// `livegs capture`: makes a scene from photos of a place. It finds poses, trains and segments in one command.
// The files of unfinished steps stay in DIR.work.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "capture/capture.h"
#include "capture/level.h"
#include "capture/read/pose_files.h"
#include "cli/capture/place_photos.h"
#include "cli/capture/train_run.h"
#include "cli/commands.h"
#include "cli/segment/segment_room.h"
#include "core/file.h"
#include "core/log.h"
#include "core/written_files.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// The frame of the poses is turned if none of its axes is this close to the vertical.
constexpr double kMaxFrameTilt_deg = 10;
// Assumed median distance between cameras and surfaces, m, if no length is known.
constexpr double kAssumedDistance_m = 1.0;

struct CaptureCommand {
  fs::path photos;
  TrainRun train;
  SegmentRequest segment;
  std::optional<double> scale;  // metres per unit of the poses
};

// The axis that is nearest to `up`, as in a scene file.
std::string axis_name(const Eigen::Vector3d& up) {
  int axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return std::string(up[axis] < 0 ? "-" : "") + "xyz"[axis];
}

Result<void> take_file(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return file_error(to, "cannot be written", error);
  note_written(to);
  return {};
}

// The photos with poses in a frame with a vertical axis.
struct LevelCapture {
  Capture capture;
  std::string up;       // axis of the frame
  bool placed = false;  // colmap found the poses in `work`, in an arbitrary unit
};
Result<LevelCapture> level_photos(const fs::path& photos, const fs::path& work) {
  LevelCapture level;
  std::error_code ignored;
  level.placed = fs::exists(photos, ignored) && !has_poses(photos);
  auto capture = level.placed ? place_photos(photos, work) : read_capture(photos);
  if (!capture) return capture.error();
  level.capture = std::move(*capture);
  for (const std::string& note : level.capture.notes) log_warn("%s: %s", photos.c_str(), note.c_str());
  Eigen::Vector3d up = photo_up(level.capture);
  if (up.cwiseAbs().maxCoeff() < std::cos(kMaxFrameTilt_deg * M_PI / 180) || level.placed) {
    level_capture(level.capture, up);
    up = Eigen::Vector3d::UnitY();
  }
  level.up = axis_name(up);
  return level;
}

int run(CaptureCommand command) {
  SegmentRequest& request = command.segment;
  if (auto checked = check_segment_folder(request.output); !checked) return report(checked.error());
  const fs::path output = fs::absolute(request.output / ".").lexically_normal().parent_path();
  const fs::path work = output.string() + ".work";
  std::error_code error;
  const bool existed = fs::exists(work, error);
  if (existed && !command.train.resume)
    return report(invalid_argument(work.string() +
                                   ": holds an unfinished capture; continue it with --resume, or "
                                   "delete it"));
  fs::create_directories(work, error);
  if (error) return report(file_error(work, "cannot be created", error));
  auto level = level_photos(command.photos, work);
  if (!level) {
    // The work folder is removed after an error in the photos, but kept for the log of a failed program.
    if (!existed && level.error().code != ErrorCode::Unavailable) fs::remove_all(work, error);
    return report(level.error());
  }
  Capture& capture = level->capture;

  const fs::path splat = work / "captured.ply", picture = work / "captured.png";
  const fs::path poses = work / "transforms.json";  // corrected by the training
  command.train.output = splat;
  if (level->placed) command.train.train.refine_poses = true;
  const bool checkpoint = fs::exists(work / "captured.checkpoint", error);
  if (!fs::exists(splat, error) || checkpoint) {
    command.train.resume = checkpoint;
    const auto outcome = run_training(capture, command.train);
    if (!outcome) {
      if (!existed && !level->placed && !fs::exists(work / "captured.checkpoint", error))
        fs::remove_all(work, error);
      return report(outcome.error());
    }
    if (outcome->interrupted) {
      std::printf("%s: stopped at step %zu of %zu; the same command with --resume continues\n", work.c_str(),
                  outcome->steps, command.train.train.steps);
      return kInterruptedExit;
    }
    std::printf("splat: %zu kernels, %.2f dB and SSIM %.3f on %zu held-out photos\n", outcome->kernels,
                outcome->score.psnr_db, outcome->score.ssim, outcome->score.views);
    for (size_t i = 0; i < capture.views.size(); ++i)
      capture.views[i].camera.world_from_camera = outcome->poses[i];
    if (auto written = write_file_atomically(poses, transforms_text(capture)); !written)
      return report(written.error());
  } else if (const auto trained = read_capture(poses);
             trained && trained->views.size() == capture.views.size()) {
    for (size_t i = 0; i < capture.views.size(); ++i)
      capture.views[i].camera.world_from_camera = trained->views[i].camera.world_from_camera;
  }
  auto asset = read_asset(splat);
  if (!asset) return report(asset.error());
  request.name = splat.string();
  request.cameras = capture.views;
  request.up = level->up;
  const bool unknown = level->placed && !command.scale;
  request.scale = command.scale.value_or(1.0);
  if (const double distance = median_distance(capture); unknown && distance > 0)
    request.scale = kAssumedDistance_m / distance;
  const auto segmented = segment_room(std::move(asset->asset), request);
  if (!segmented) {
    log_warn("%s: the splat is kept; draw it with livegs render, or use it as the environment of a scene",
             splat.c_str());
    return report(segmented.error());
  }
  if (auto taken = take_file(splat, output / "captured.ply"); !taken) return report(taken.error());
  if (auto taken = take_file(picture, output / "captured.png"); !taken) return report(taken.error());
  if (auto written = write_file_atomically(output / "transforms.json", transforms_text(capture)); !written)
    return report(written.error());
  fs::remove_all(work, error);
  if (unknown) {
    log_warn(
        "scale: unknown, %.3g m per unit assumed for photos from %.3g m away; measure the longest side of "
        "one thing, then run livegs segment %s --cameras %s --known part_01=METRES -o DIR",
        segmented->scale, kAssumedDistance_m, (output / "captured.ply").c_str(),
        (output / "transforms.json").c_str());
  }
  std::printf("%s: %zu things; run livegs-server %s\n", request.output.c_str(), segmented->things,
              (request.output / "room.scene.json").c_str());
  return 0;
}

}  // namespace

void add_capture(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CaptureCommand>();
  TrainOptions& train = options->train.train;
  train.steps = 2000;
  train.max_kernels = 20'000;
  CLI::App* command =
      app.add_subcommand("capture", "Make a scene from photos of a place, with each thing as an object");
  command
      ->add_option("PHOTOS", options->photos,
                   "Folder of photos. Poses are read from transforms.json or a COLMAP model in it; if both "
                   "are missing, the program colmap computes the poses")
      ->required()
      ->type_name("");
  command
      ->add_option("--output,-o", options->segment.output,
                   "Output folder, new or empty: things, room, scene, page and the whole splat. DIR.work "
                   "contains the files of an unfinished run")
      ->required()
      ->type_name("DIR");
  add_train_options(*command, options->train);
  command
      ->add_option("--scale", options->scale,
                   "Metres per unit of the poses (default: 1, or a guess if colmap finds the poses)")
      ->check(CLI::Range(1e-6, 1e6));
  command->add_flag("--resume", options->train.resume, "Continue an interrupted run from DIR.work");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
