// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "capture/capture.h"
#include "cli/choose_device.h"
#include "cli/commands.h"
#include "cli/output_path.h"
#include "core/file.h"
#include "core/log.h"
#include "gaussian/asset_file.h"
#include "train/trainer.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct TrainCommand {
  fs::path photos, output;
  TrainOptions train;
  std::string shape = "needle", device = "auto";
  size_t every = 500;
  bool resume = false;
};

// Exit code after Ctrl-C, as a shell reports it.
constexpr int kInterrupted = 128 + SIGINT;

volatile std::sig_atomic_t train_interrupted = 0;

// The second signal ends the program at once.
extern "C" void note_train_interrupt(int) {
  train_interrupted = 1;
  std::signal(SIGINT, SIG_DFL);
}

fs::path with_ending(fs::path path, const char* ending) { return path.replace_extension(ending); }

// One line of progress, and the picture of the first view that is held out.
struct Progress {
  const TrainCommand& options;
  const Capture& capture;
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  size_t first_step = 0;

  Result<HeldOutScore> report(Trainer& trainer) const {
    auto score = trainer.score();
    if (!score) return score.error();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const size_t done = trainer.steps_done(), left = options.train.steps - done;
    const double remaining_s =
        seconds * static_cast<double>(left) / static_cast<double>(std::max<size_t>(1, done - first_step));
    if (score->views > 0) {
      log_info(
          "step %zu of %zu: %.2f dB, SSIM %.3f on %zu held-out photos, %zu kernels, %.0f s, about %.0f s "
          "left",
          done, options.train.steps, score->psnr_db, score->ssim, score->views, trainer.kernels().size(),
          seconds, remaining_s);
    } else {
      log_info("step %zu of %zu: loss %.4f, %zu kernels, %.0f s, about %.0f s left", done,
               options.train.steps, trainer.recent_loss(), trainer.kernels().size(), seconds, remaining_s);
    }
    size_t shown = 0;
    for (size_t i = capture.views.size(); i-- > 0;) {
      if (capture.views[i].held_out) shown = i;
    }
    auto picture = trainer.compare(shown);
    if (!picture) return picture.error();
    if (auto written = write_png(with_ending(options.output, ".png"), *picture); !written)
      return written.error();
    return score;
  }
};

int run(TrainCommand options) {
  if (auto checked = check_output_file(options.output, {".ply", ".spz"}); !checked)
    return report(checked.error());
  options.train.shape.loss = options.shape == "none"     ? ShapeLoss::None
                             : options.shape == "needle" ? ShapeLoss::Needle
                                                         : ShapeLoss::Anisotropy;
  auto capture = read_capture(options.photos);
  if (!capture) return report(capture.error());
  for (const std::string& note : capture->notes) log_warn("%s: %s", options.photos.c_str(), note.c_str());
  auto trainer = Trainer::start(*capture, options.train);
  if (!trainer) return report(trainer.error());
  auto device = choose_device(options.device);
  if (!device) return report(device.error());
  if (*device) trainer->use_device(*std::move(device));
  const fs::path checkpoint = with_ending(options.output, ".checkpoint");
  if (options.resume) {
    const auto bytes = read_file(checkpoint);
    if (!bytes) return report(bytes.error());
    if (auto resumed = trainer->resume(*bytes); !resumed) return report(resumed.error());
  }
  log_info("%s: %zu photos, %zu points, extent %.3g units; %zu kernels at the start", options.photos.c_str(),
           capture->views.size(), capture->points.size(), trainer->extent(), trainer->kernels().size());

  std::signal(SIGINT, note_train_interrupt);
  const Progress progress{options, *capture, std::chrono::steady_clock::now(), trainer->steps_done()};
  HeldOutScore best_score;
  std::optional<GaussianAsset> best;
  while (!trainer->done() && train_interrupted == 0) {
    if (auto stepped = trainer->step(); !stepped) return report(stepped.error());
    if (trainer->steps_done() % options.every != 0 || trainer->done()) continue;
    const auto score = progress.report(*trainer);
    if (!score) return report(score.error());
    if (score->psnr_db >= best_score.psnr_db) {
      best_score = *score;
      best = trainer->asset();
    }
    if (auto written = write_file_atomically(checkpoint, trainer->checkpoint()); !written)
      return report(written.error());
  }
  const auto last = progress.report(*trainer);
  if (!last) return report(last.error());
  const bool earlier_is_better = train_interrupted != 0 && best && best_score.psnr_db > last->psnr_db;
  if (auto written = write_asset(options.output, earlier_is_better ? *best : trainer->asset()); !written)
    return report(written.error());
  if (!trainer->done()) {
    if (auto written = write_file_atomically(checkpoint, trainer->checkpoint()); !written)
      return report(written.error());
    std::printf("%s: stopped at step %zu of %zu; the same command with --resume continues\n",
                options.output.c_str(), trainer->steps_done(), options.train.steps);
    return kInterrupted;
  }
  std::error_code ignored;
  fs::remove(checkpoint, ignored);
  std::printf("%s: %zu kernels, %.2f dB and SSIM %.3f on %zu held-out photos\n", options.output.c_str(),
              trainer->kernels().size(), last->psnr_db, last->ssim, last->views);
  return 0;
}

}  // namespace

void add_train(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<TrainCommand>();
  TrainOptions& train = options->train;
  CLI::App* command = app.add_subcommand("train", "Train a splat from photos with poses");
  command
      ->add_option("PHOTOS", options->photos,
                   "Folder with transforms.json or a COLMAP model in sparse/0, or a transforms file")
      ->required()
      ->type_name("");
  command
      ->add_option("--output,-o", options->output,
                   "Output: a .ply or .spz file in the frame of the poses; the same name with .png shows a "
                   "photo and the "
                   "splat, with .checkpoint it keeps the state")
      ->required()
      ->type_name("FILE");
  command->add_option("--steps", train.steps, "Number of steps, one photo each")
      ->check(CLI::Range(size_t{1}, kMaxTrainSteps))
      ->capture_default_str();
  command->add_option("--kernels", train.max_kernels, "Limit of the number of kernels")
      ->check(CLI::Range(size_t{100}, kMaxTrainedKernels))
      ->capture_default_str();
  command->add_option("--size", train.longest_px, "Longest edge of the photos in training, pixels")
      ->check(CLI::Range(32, 16384))
      ->capture_default_str();
  command
      ->add_option("--shape", options->shape,
                   "Shape loss: needle (no long kernels), anisotropy (no flat ones either) or none")
      ->check(CLI::IsMember({"needle", "anisotropy", "none"}))
      ->type_name("LOSS")
      ->capture_default_str();
  command->add_option("--shape-limit", train.shape.limit, "Ratio of axes up to which the shape has no loss")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  command->add_option("--every", options->every, "Steps between a score, a picture and a checkpoint")
      ->check(CLI::Range(size_t{1}, kMaxTrainSteps))
      ->capture_default_str();
  command->add_option("--seed", train.seed, "Seed of all random choices")->capture_default_str();
  add_device_option(*command, options->device);
  command->add_flag("--ignore-masked", train.ignore_masked, "Pixels whose mask is 0 do not count");
  command->add_flag("--resume", options->resume, "Continue from the checkpoint of an interrupted run");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
