// SPDX-License-Identifier: GPL-3.0-or-later
// livegs fit: physical parameters of a scene's objects from a video of their motion.
#include <signal.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/fit/rebase_scene.h"
#include "cli/job/job.h"
#include "cli/output_path.h"
#include "cli/shown_paths.h"
#include "core/clock.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "core/text/help_format.h"
#include "core/text/shown_text.h"
#include "core/written_files.h"
#include "fit/draw_tracks.h"
#include "fit/fit_scene.h"
#include "scene/edit/scene_document.h"
#include "splat/camera_file.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct FitCommand {
  fs::path scene, video, tracks, camera, output;
  std::vector<std::string> find;
  double first_frame_s = 0, max_seconds = 10, every_s = 10;
  bool quiet = false;       // --quiet of the program
  bool at_address = false;  // the scene or the output: the fitted scene keeps the paths of the scene
  JobOptions job;
};

std::atomic<bool> fit_interrupted{false};

// NAME or NAME=QUANTITY,…
Result<std::pair<std::string, std::vector<FitQuantity>>> read_find(const std::string& text) {
  const size_t equals = text.rfind('=');
  std::pair<std::string, std::vector<FitQuantity>> wanted{text.substr(0, equals), {}};
  for (size_t begin = equals; begin != std::string::npos;) {
    const size_t end = text.find(',', begin + 1);
    const std::string name = text.substr(begin + 1, end == std::string::npos ? end : end - begin - 1);
    const auto quantity = fit_quantity(name);
    if (!quantity) {
      std::string all;
      for (const FitQuantityName& one : kFitQuantities)
        all += std::string(all.empty() ? "" : ", ") + one.name;
      return invalid_argument("--find " + text + ": \"" + name + "\" is unknown; use one or more of " + all);
    }
    wanted.second.push_back(*quantity);
    begin = end;
  }
  if (wanted.first.empty())
    return invalid_argument("--find " + text + ": has no object; give NAME=QUANTITY,...");
  return wanted;
}

// The picture size of the camera is that of the video. With --tracks, it is that of the camera file.
Result<FitRequest> request_of(const FitCommand& command) {
  FitRequest request;
  for (const std::string& text : command.find) {
    auto wanted = read_find(text);
    if (!wanted) return wanted.error();
    request.objects.push_back(std::move(*wanted));
  }
  auto camera = read_camera_file(command.camera);
  if (!camera) return camera.error();
  request.camera = *camera;
  auto scene = read_scene(command.scene);
  if (!scene) return scene.error();
  request.scene = std::move(*scene);
  request.first_frame_s = command.first_frame_s;
  request.max_seconds = command.max_seconds;
  return request;
}

nlohmann::json json_of(const FitResult& result) {
  nlohmann::json json;
  json["version"] = LIVEGS_VERSION;
  json["points"] = result.measured.points();
  json["frames"] = result.measured.frames();
  json["simulations"] = result.simulations;
  json["spread_px"] = result.spread_px;
  json["spread_before_px"] = result.spread_before_px;
  json["picture_scale"] = result.picture_scale;
  json["shift_s"] = result.shift_s;
  json["values"] = nlohmann::json::array();
  for (const FittedValue& value : result.values) {
    json["values"].push_back({{"object", value.parameter.object},
                              {"quantity", names_of(value.parameter.quantity).name},
                              {"asked", value.parameter.asked},
                              {"low", value.low},
                              {"best", value.best},
                              {"high", value.high},
                              {"before", value.parameter.before},
                              {"before_source", value.parameter.source},
                              {"shown", value.shown}});
  }
  json["notes"] = result.notes;
  return json;
}

void print_values(const FitResult& result) {
  std::printf("%-16s %-18s %10s %23s %10s  %s\n", "object", "quantity", "best", "90 % range", "before", "of");
  for (const FittedValue& value : result.values) {
    const FitQuantityName& names = names_of(value.parameter.quantity);
    std::printf("%-16s %-18s %10.4g %10.4g to %9.4g %10.4g  %s%s\n", value.parameter.object.c_str(),
                names.name, value.best, value.low, value.high, value.parameter.before,
                value.parameter.source.c_str(), value.parameter.asked ? "" : "; varied as uncertain");
  }
  std::printf(
      "%zu points in %zu frames; simulated and measured paths are %.2f px apart, %.2f px before; %zu "
      "simulations\n",
      result.measured.points(), result.measured.frames(), result.spread_px, result.spread_before_px,
      result.simulations);
  for (const std::string& note : result.notes) std::printf("note: %s\n", shown_text(note, 400).c_str());
}

Result<void> write_result(const FitCommand& command, const FitRequest& request, const FitResult& result,
                          Image picture) {
  const fs::path& folder = command.output;
  const auto text = [&](const char* name, const std::string& content) -> Result<void> {
    auto written = write_file_atomically(folder / name, content);
    if (written) note_written(folder / name);
    return written;
  };
  if (auto done = text("fit.json", json_of(result).dump(2) + "\n"); !done) return done;
  auto scene = scene_text(command.at_address ? result.scene
                                             : rebase_scene(result.scene, request.scene.folder, folder));
  if (!scene) return scene.error();
  if (auto done = text("fitted.scene.json", *scene); !done) return done;
  for (const auto& [name, tracks] :
       {std::pair("measured.csv", &result.measured), {"simulated.csv", &result.simulated}}) {
    if (auto done = write_tracks_file(folder / name, *tracks); !done) return done;
    note_written(folder / name);
  }
  if (picture.pixels.empty()) {  // of --tracks
    picture.width = request.camera.width;
    picture.height = request.camera.height;
    picture.pixels.assign(
        size_t{4} * static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height), 0.3f);
  }
  draw_tracks(result.measured, result.simulated, picture);
  if (auto done = write_png(folder / "paths.png", picture); !done) return done;
  note_written(folder / "paths.png");
  return {};
}

int run_fit(const FitCommand& command, Job& job) {
  if (!std::isfinite(command.first_frame_s) || !std::isfinite(command.max_seconds))
    return report(invalid_argument("--first-frame, --max-seconds: must be finite numbers"));
  if (auto checked = check_output_folder(command.output); !checked) return report_job(checked.error());
  auto request = request_of(command);
  if (!request) return report(request.error());
  // Ctrl-C ends the search; the best values so far are written. A second one ends the program.
  struct sigaction action {};
  action.sa_handler = [](int) { fit_interrupted = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  const int64_t started_ns = now_ns();
  size_t lines = 0;
  SimulationJournal journal;
  if (job.keeps_state()) {
    const auto state = job.last_state();
    if (!state) return report_job(state.error());
    if (*state) {
      if (auto read = journal.read(**state); !read) log_warn("%s", read.error().message.c_str());
    }
    request->journal = &journal;
  }
  size_t kept = journal.size();
  int64_t next_ns = started_ns + static_cast<int64_t>(1e9 * command.every_s);
  const auto keep_state = [&] {
    if (!job.keeps_state() || journal.size() == kept || now_ns() < next_ns) return;
    const int64_t begun_ns = now_ns();
    kept = journal.size();
    if (auto stored = job.keep_state(kept, journal.bytes()); !stored)
      log_warn("%s", stored.error().message.c_str());
    // A slow store does not take more than a tenth of the time.
    next_ns = now_ns() + std::max(static_cast<int64_t>(1e9 * command.every_s), 9 * (now_ns() - begun_ns));
  };
  const FitProgress progress = [&](const std::string& line) {
    job.progress(++lines, 0);
    keep_state();
    set_log_level(LogLevel::Error);  // each simulation would print the notes of the first one
    if (!command.quiet)
      std::fprintf(stderr, "%5.0f s  %s\n", milliseconds_from_ns(now_ns() - started_ns) / 1000, line.c_str());
    return !fit_interrupted;
  };
  Image picture;
  auto tracks = command.tracks.empty() ? track_video(*request, command.video, progress, &picture)
                                       : read_tracks_file(command.tracks);
  if (!tracks) return report_job(tracks.error());
  auto result = fit_scene(*request, *tracks, progress);
  if (!result) return report(result.error());
  std::error_code error;
  fs::create_directories(command.output, error);
  if (error)
    return report({ErrorCode::PermissionDenied, command.output.string() + ": cannot be created: " +
                                                    error.message() + "; give another folder with --output"});
  if (auto written = write_result(command, *request, *result, std::move(picture)); !written)
    return report_job(written.error());
  if (fit_interrupted) job.leave_unmarked();
  job.progress(lines, lines);
  print_values(*result);
  std::fputs(with_shown_paths(written_files_text()).c_str(), stdout);
  return 0;
}

}  // namespace

void add_fit(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<FitCommand>();
  CLI::App* command = app.add_subcommand(
      "fit", "Find stiffness, damping, mass or friction of objects from a video of their motion");
  command
      ->add_option("SCENE", options->scene,
                   "*.scene.json with the loads on the objects, as events and motions")
      ->required();
  CLI::Option* video =
      command->add_option("--video", options->video, "Video of the motion, from a camera at rest");
  CLI::Option* tracks =
      command
          ->add_option("--tracks", options->tracks,
                       "Instead of --video: CSV file of the paths of surface points in the picture, "
                       "with the header point,time_s,x_px,y_px")
          ->excludes(video);
  command
      ->add_option("--camera", options->camera,
                   "Camera file: position, target, field of view and size of the video")
      ->required();
  command->add_option(
      "--find", options->find,
      "Object and quantities to find, such as hat=youngs_modulus_pa,damping; may be repeated (default: the "
      "only moving object, with youngs_modulus_pa and damping if it is elastic, else friction and "
      "restitution)");
  command
      ->add_option("--first-frame", options->first_frame_s, "Scene time at the first frame of the video, s")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  command->add_option("--max-seconds", options->max_seconds, "Use only this length of the recording")
      ->check(CLI::Range(0.05, 60.0))
      ->capture_default_str();
  command
      ->add_option("--every", options->every_s,
                   "With --checkpoints: interval in seconds at which the state is stored")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  command
      ->add_option("--output,-o", options->output,
                   "Output folder: fit.json, fitted.scene.json, paths.png, measured.csv and simulated.csv")
      ->required();
  group_options(*command, "Recording",
                {{"--video", "FILE"},
                 {"--tracks", "FILE"},
                 {"--camera", "CAMERA_FILE"},
                 {"--first-frame", "SECONDS"},
                 {"--max-seconds", "SECONDS"}});
  group_options(*command, "Result",
                {{"--find", "NAME[=QUANTITY,...]"}, {"--output", "FOLDER"}, {"--every", "SECONDS"}});
  command->footer(
      "Examples:\n"
      "  livegs fit hat.scene.json --video hat.mp4 --camera camera.json -o out/fit\n"
      "  livegs fit desk.scene.json --tracks paths.csv --camera camera.json --find leaf=youngs_modulus_pa -o "
      "out/leaf");
  add_job_options(*command, options->job);
  command->callback([options, command, video, tracks, &app, &exit_code] {
    options->quiet = app.get_option("--quiet")->count() > 0;
    options->at_address = is_store_url(options->scene.string()) || is_store_url(options->output.string());
    exit_code = video->count() + tracks->count() == 0
                    ? report(invalid_argument("fit: give --video or --tracks"))
                    : run_as_job(*command, options->job,
                                 {&options->scene, &options->video, &options->tracks, &options->camera},
                                 &options->output, JobOutput::Folder,
                                 [&](Job& job) { return run_fit(*options, job); });
  });
}

}  // namespace livegs
