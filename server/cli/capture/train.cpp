// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>
#include <filesystem>
#include <memory>

#include "capture/capture.h"
#include "cli/capture/train_run.h"
#include "cli/commands.h"
#include "cli/output_path.h"
#include "cli/shown_paths.h"
#include "core/log.h"

namespace livegs {
namespace {

struct TrainCommand {
  std::filesystem::path photos;
  TrainRun run;
  std::string shape = "needle";
  JobOptions job;
};

// The poses name photos and points, which may be outside their folder.
Result<void> add_photos(const std::filesystem::path& photos, Job& job) {
  const auto capture = read_capture(photos);
  if (!capture) return capture.error();
  for (const CapturedView& view : capture->views) {
    for (const std::filesystem::path& file : {view.picture, view.mask, view.depth}) {
      if (file.empty()) continue;
      if (auto added = job.add_input_file(file); !added) return added;
    }
  }
  // A file of poses stands for those next to it.
  std::error_code ignored;
  for (const char* name : {"transforms.json", "transforms_train.json", "transforms_test.json"}) {
    const std::filesystem::path poses = std::filesystem::absolute(photos).parent_path() / name;
    if (!std::filesystem::is_regular_file(photos, ignored) ||
        !std::filesystem::is_regular_file(poses, ignored))
      continue;
    if (auto added = job.add_input_file(poses); !added) return added;
  }
  job.add_input_bytes(std::as_bytes(std::span(capture->points)));
  job.add_input_bytes(std::as_bytes(std::span(capture->point_colours)));
  return {};
}

int train(TrainCommand options, Job& job) {
  options.run.job = &job;
  if (auto checked = check_output_file(options.run.output, {".ply", ".spz"}); !checked)
    return report(checked.error());
  options.run.train.shape.loss = options.shape == "none"     ? ShapeLoss::None
                                 : options.shape == "needle" ? ShapeLoss::Needle
                                                             : ShapeLoss::Anisotropy;
  const auto capture = read_capture(options.photos);
  if (!capture) return report(capture.error());
  for (const std::string& note : capture->notes)
    log_warn("%s: %s", with_shown_paths(options.photos.string()).c_str(), note.c_str());
  const auto outcome = run_training(*capture, options.run);
  if (!outcome) return report_job(outcome.error());
  if (outcome->evicted) {
    std::printf("stopped at step %zu of %zu; the same command continues\n", outcome->steps,
                options.run.train.steps);
    return kRetryExit;
  }
  const std::string output = with_shown_paths(options.run.output.string());
  if (outcome->interrupted) {
    const char* next = job.keeps_state()                       ? "; the same command continues"
                       : output == options.run.output.string() ? "; the same command with --resume continues"
                                                               : "";
    std::printf("%s: stopped at step %zu of %zu%s\n", output.c_str(), outcome->steps, options.run.train.steps,
                next);
    return kInterruptedExit;
  }
  std::printf("%s: %zu kernels, %.2f dB and SSIM %.3f on %zu held-out photos\n", output.c_str(),
              outcome->kernels, outcome->score.psnr_db, outcome->score.ssim, outcome->score.views);
  return 0;
}

}  // namespace

void add_train(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<TrainCommand>();
  TrainRun& run = options->run;
  TrainOptions& settings = run.train;
  CLI::App* command = app.add_subcommand("train", "Train a splat from photos with poses");
  command
      ->add_option("PHOTOS", options->photos,
                   "Folder with transforms.json or a COLMAP model in sparse/0, or a transforms file")
      ->required()
      ->type_name("");
  command
      ->add_option(
          "--output,-o", run.output,
          "Output: a .ply or .spz file in the frame of the poses. Also written: a picture of a photo and the "
          "splat, with the ending .png, and the state, with the ending .checkpoint")
      ->required()
      ->type_name("FILE");
  add_train_options(*command, run);
  command
      ->add_option("--shape", options->shape,
                   "Shape loss: needle (against long kernels), anisotropy (also against flat ones) or none")
      ->check(CLI::IsMember({"needle", "anisotropy", "none"}))
      ->type_name("LOSS")
      ->capture_default_str();
  command->add_option("--shape-limit", settings.shape.limit, "Largest ratio of axes without a shape loss")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--every", run.every,
                   "Number of steps after which a score, a picture and a checkpoint are written")
      ->check(CLI::Range(size_t{1}, kMaxTrainSteps))
      ->capture_default_str();
  command->add_option("--seed", settings.seed, "Seed of all random choices")->capture_default_str();
  command->add_flag("--ignore-masked", settings.ignore_masked, "Ignore pixels whose mask is 0");
  command->add_flag("--resume", run.resume, "Continue from the checkpoint of an interrupted run");
  add_job_options(*command, options->job);
  command->callback([options, command, &exit_code] {
    exit_code = run_as_job(
        *command, options->job, {&options->photos}, &options->run.output, JobOutput::File,
        [&](Job& job) { return train(*options, job); },
        [&](Job& job) { return add_photos(options->photos, job); });
  });
}

}  // namespace livegs
