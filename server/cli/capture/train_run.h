// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "cli/job/job.h"
#include "core/result.h"
#include "train/train_options.h"
#include "train/trainer.h"

namespace livegs {

// A training run that can be watched and interrupted.
struct TrainRun {
  // NAME.ply or NAME.spz. NAME.png shows a photo and the splat, NAME.checkpoint keeps the state.
  std::filesystem::path output;
  TrainOptions train;
  std::string device = "auto";  // see choose_device.h
  size_t every = 500;           // steps between a score, a picture and a checkpoint
  bool resume = false;          // continue from the checkpoint
  // Keeps the state in place of NAME.checkpoint if it has checkpoints: the run continues from the newest one,
  // and SIGTERM ends it after the current step with its state kept. Null: none.
  Job* job = nullptr;
};
struct TrainOutcome {
  HeldOutScore score;
  size_t steps = 0, kernels = 0;
  bool interrupted = false;   // by Ctrl-C; the output is then the best splat so far
  bool evicted = false;       // by SIGTERM; there is no output, and the job keeps the state
  std::vector<Pose> poses{};  // corrected ones of the cameras, by view
};

// Adds --steps, --kernels, --size and --device; the values of `run` are the defaults.
void add_train_options(CLI::App& command, TrainRun& run);

// Trains and writes the files. Ctrl-C ends the run after the current step, a second one the program.
Result<TrainOutcome> run_training(const Capture& capture, const TrainRun& run);

}  // namespace livegs
