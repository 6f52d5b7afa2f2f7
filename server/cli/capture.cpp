// SPDX-License-Identifier: GPL-3.0-or-later
// `livegs capture`: photos to a scene of things that can be taken hold of. Poses, training and segmentation
// in one command; the files of unfinished steps stay in DIR.work.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "capture/capture.h"
#include "capture/level.h"
#include "cli/choose_device.h"
#include "cli/commands.h"
#include "cli/place_photos.h"
#include "cli/segment_room.h"
#include "cli/train_run.h"
#include "core/file.h"
#include "core/log.h"
#include "core/written_files.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// Poses are turned if no axis of their frame is this close to the vertical.
constexpr double kMaxFrameTilt_deg = 10;
// Without a known length: the median distance between cameras and what they see, m.
constexpr double kAssumedDistance_m = 1.0;

struct CaptureCommand {
  fs::path photos;
  TrainRun train;
  SegmentRequest segment;
  std::string known;
  double scale = 0;  // metres per unit of the poses; 0: 1, or a guess if the poses are found
};

bool has_vertical_axis(const Eigen::Vector3d& up) {
  return up.cwiseAbs().maxCoeff() >= std::cos(kMaxFrameTilt_deg * M_PI / 180);
}

Result<void> take_file(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error)
    return Error{ErrorCode::PermissionDenied, to.string() + ": cannot be written: " + error.message()};
  note_written(to);
  return {};
}

// Poses of the files, or found in `work`. `guessed` is set if the unit of length is arbitrary.
Result<Capture> capture_of(const CaptureCommand& command, const fs::path& work, bool& guessed) {
  auto capture = read_capture(command.photos);
  std::error_code error;
  guessed = !capture && capture.error().code == ErrorCode::NotFound &&
            fs::is_directory(command.photos, error) && photo_folder(command.photos);
  if (guessed) capture = place_photos(command.photos, work);
  if (!capture) return capture;
  for (const std::string& note : capture->notes) log_warn("%s: %s", command.photos.c_str(), note.c_str());
  if (const Eigen::Vector3d up = photo_up(*capture); guessed || !has_vertical_axis(up))
    level_capture(*capture, up);
  return capture;
}

int run(CaptureCommand command) {
  SegmentRequest& request = command.segment;
  if (auto checked = check_segment_folder(request.output); !checked) return report(checked.error());
  if (!command.known.empty()) {
    auto known = read_known_length(command.known);
    if (!known) return report(known.error());
    request.known = *known;
  }
  const fs::path output = fs::absolute(request.output / ".").lexically_normal().parent_path();
  const fs::path work = output.string() + ".work";
  std::error_code error;
  const bool existed = fs::exists(work, error);
  if (existed && !command.train.resume)
    return report(invalid_argument(work.string() +
                                   ": holds an unfinished capture; continue it with --resume, or "
                                   "delete it"));
  fs::create_directories(work, error);
  if (error)
    return report({ErrorCode::PermissionDenied, work.string() + ": cannot be created: " + error.message()});
  // Bad photos leave nothing behind.
  const auto refuse = [&](const Error& why) {
    if (!existed && why.code != ErrorCode::Unavailable) fs::remove_all(work, error);
    return report(why);
  };
  bool guessed = false;
  const auto capture = capture_of(command, work, guessed);
  if (!capture) return refuse(capture.error());

  const fs::path splat = work / "captured.ply", picture = work / "captured.png";
  command.train.output = splat;
  const bool checkpoint = fs::exists(work / "captured.checkpoint", error);
  if (!fs::exists(splat, error) || checkpoint) {
    command.train.resume = checkpoint;
    const auto outcome = run_training(*capture, command.train);
    if (!outcome) return refuse(outcome.error());
    if (outcome->interrupted) {
      std::printf("%s: stopped at step %zu of %zu; the same command with --resume continues\n", work.c_str(),
                  outcome->steps, command.train.train.steps);
      return kInterruptedExit;
    }
    std::printf("splat: %zu kernels, %.2f dB and SSIM %.3f on %zu held-out photos\n", outcome->kernels,
                outcome->score.psnr_db, outcome->score.ssim, outcome->score.views);
  }
  auto asset = read_asset(splat);
  if (!asset) return report(asset.error());
  request.name = splat.string();
  request.cameras = capture->views;
  request.scale = command.scale > 0 ? command.scale : 1.0;
  const bool unknown = guessed && command.scale == 0 && !request.known;
  if (unknown)
    if (const double distance = median_distance(*capture); distance > 0)
      request.scale = kAssumedDistance_m / distance;
  const auto segmented = segment_room(std::move(asset->asset), request);
  if (!segmented) {
    log_warn("%s: kept; look at it with livegs render, or put it into a scene as its environment",
             splat.c_str());
    return report(segmented.error());
  }
  if (auto taken = take_file(splat, output / "captured.ply"); !taken) return report(taken.error());
  if (auto taken = take_file(picture, output / "captured.png"); !taken) return report(taken.error());
  if (auto written = write_file_atomically(output / "transforms.json", transforms_text(*capture)); !written)
    return report(written.error());
  fs::remove_all(work, error);
  if (unknown) {
    log_warn(
        "scale: unknown; %.3g m per unit assumes that the photos were taken %.3g m away. With the longest "
        "side of "
        "one thing: livegs segment %s --cameras %s --known part_01=METRES -o DIR",
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
  CLI::App* command = app.add_subcommand(
      "capture", "Make a scene of things that can be taken hold of from photos of a place");
  command
      ->add_option(
          "PHOTOS", options->photos,
          "Folder of photos, with transforms.json or a COLMAP model if there is one; else the program "
          "colmap finds the poses")
      ->required()
      ->type_name("");
  command
      ->add_option(
          "--output,-o", options->segment.output,
          "Output folder, new or empty: things, room, scene, page and the whole splat. DIR.work keeps "
          "what is unfinished")
      ->required()
      ->type_name("DIR");
  command->add_option("--steps", train.steps, "Number of training steps, one photo each")
      ->check(CLI::Range(size_t{1}, kMaxTrainSteps))
      ->capture_default_str();
  command->add_option("--kernels", train.max_kernels, "Limit of the number of kernels")
      ->check(CLI::Range(size_t{100}, kMaxTrainedKernels))
      ->capture_default_str();
  command->add_option("--size", train.longest_px, "Longest edge of the photos in training, pixels")
      ->check(CLI::Range(32, 16384))
      ->capture_default_str();
  CLI::Option* scale =
      command->add_option("--scale", options->scale, "Metres per unit of the poses (default: 1)")
          ->check(CLI::Range(1e-6, 1e6));
  command
      ->add_option(
          "--known", options->known,
          "A thing of an earlier run and its longest side in metres, such as part_03=0.21; sets the scale")
      ->type_name("NAME=M")
      ->excludes(scale);
  add_device_option(*command, options->train.device);
  command->add_flag("--resume", options->train.resume, "Continue an interrupted run from DIR.work");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
