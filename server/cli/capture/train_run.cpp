// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/capture/train_run.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <optional>

#include "cli/choose_device.h"
#include "cli/shown_paths.h"
#include "core/file.h"
#include "core/log.h"
#include "gaussian/asset_file.h"

namespace livegs {

namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t train_interrupted = 0;  // the signal

// The second signal ends the program at once.
extern "C" void note_train_interrupt(int signal_number) {
  train_interrupted = signal_number;
  std::signal(signal_number, SIG_DFL);
}

fs::path with_ending(fs::path path, const char* ending) { return path.replace_extension(ending); }

// One line of progress, and the picture of the first view that is held out.
struct Progress {
  const TrainRun& options;
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

}  // namespace

void add_train_options(CLI::App& command, TrainRun& run) {
  command.add_option("--steps", run.train.steps, "Number of training steps, one photo each")
      ->check(CLI::Range(size_t{1}, kMaxTrainSteps))
      ->capture_default_str();
  command.add_option("--kernels", run.train.max_kernels, "Limit of the number of kernels")
      ->check(CLI::Range(size_t{100}, kMaxTrainedKernels))
      ->capture_default_str();
  command.add_option("--size", run.train.longest_px, "Longest edge of the photos in training, pixels")
      ->check(CLI::Range(32, 16384))
      ->capture_default_str();
  command.add_flag("--refine-poses", run.train.refine_poses,
                   "Correct the poses of the cameras in training; always done for those of colmap");
  add_device_option(command, run.device);
}

Result<TrainOutcome> run_training(const Capture& capture, const TrainRun& run) {
  auto trainer = Trainer::start(capture, run.train);
  if (!trainer) return trainer.error();
  auto device = choose_device(run.device);
  if (!device) return device.error();
  if (*device) trainer->use_device(*std::move(device));
  const fs::path checkpoint = with_ending(run.output, ".checkpoint");
  const bool keeps = run.job && run.job->keeps_state();
  const auto keep = [&]() -> Result<void> {
    const auto state = trainer->checkpoint();
    return keeps ? run.job->keep_state(trainer->steps_done(), state)
                 : write_file_atomically(checkpoint, state);
  };
  if (keeps) {
    const auto state = run.job->last_state();
    if (!state) return state.error();
    if (*state) {
      if (auto resumed = trainer->resume(**state); !resumed) return resumed.error();
    }
  } else if (run.resume) {
    const auto bytes = read_file(checkpoint);
    if (!bytes) return bytes.error();
    if (auto resumed = trainer->resume(*bytes); !resumed) return resumed.error();
  }
  log_info("%s: %zu photos, %zu points, extent %.3g units; %zu kernels at the start",
           with_shown_paths(capture.folder.string()).c_str(), capture.views.size(), capture.points.size(),
           trainer->extent(), trainer->kernels().size());

  std::signal(SIGINT, note_train_interrupt);
  if (keeps) std::signal(SIGTERM, note_train_interrupt);
  const Progress progress{run, capture, std::chrono::steady_clock::now(), trainer->steps_done()};
  HeldOutScore best_score;
  std::optional<GaussianAsset> best;
  while (!trainer->done() && train_interrupted == 0) {
    if (auto stepped = trainer->step(); !stepped) return stepped.error();
    if (run.job) run.job->progress(trainer->steps_done(), run.train.steps);
    if (trainer->steps_done() % run.every != 0 || trainer->done()) continue;
    const auto score = progress.report(*trainer);
    if (!score) return score.error();
    if (score->psnr_db >= best_score.psnr_db) {
      best_score = *score;
      best = trainer->asset();
    }
    if (auto kept = keep(); !kept) {
      if (!keeps) return kept.error();
      log_warn("checkpoint: not saved, training continues: %s", kept.error().message.c_str());
    }
  }
  if (train_interrupted == SIGTERM) {
    if (auto kept = keep(); !kept) return kept.error();
    return TrainOutcome{{}, trainer->steps_done(), trainer->kernels().size(), true, true};
  }
  // The rest takes less than the steps since the last state.
  if (keeps) run.job->end_at_sigterm();
  const bool early = !trainer->done();
  const auto last = progress.report(*trainer);
  if (!last) return last.error();
  const bool earlier_is_better = early && best && best_score.psnr_db > last->psnr_db;
  if (auto written = write_asset(run.output, earlier_is_better ? *best : trainer->asset()); !written)
    return written.error();
  TrainOutcome outcome{*last, trainer->steps_done(), trainer->kernels().size(), !trainer->done()};
  for (size_t i = 0; i < capture.views.size(); ++i)
    outcome.poses.push_back(trainer->camera(i).world_from_camera);
  if (outcome.interrupted) {
    if (auto kept = keep(); !kept) return kept.error();
  } else if (!keeps) {
    std::error_code ignored;
    fs::remove(checkpoint, ignored);
  }
  return outcome;
}

}  // namespace livegs
