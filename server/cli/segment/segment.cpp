// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>
#include <filesystem>
#include <memory>

#include "capture/read/pose_files.h"
#include "cli/commands.h"
#include "cli/job/job.h"
#include "cli/segment/segment_room.h"
#include "cli/shown_paths.h"
#include "core/log.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

constexpr size_t kSteps = 1000;  // of the whole work, for the metrics

struct SegmentCommand {
  std::filesystem::path input, cameras;
  std::string known;
  SegmentRequest request;
  JobOptions job;
};

int segment(SegmentCommand command, Job& job) {
  SegmentRequest& request = command.request;
  request.progress = [&job](double done) { job.progress(static_cast<size_t>(kSteps * done), kSteps); };
  // An earlier run of this job found the folder new and was killed before its mark.
  const auto begun = job.begun_before();
  if (!begun) return report_job(begun.error());
  if (!*begun) {
    if (auto checked = check_segment_folder(request.output); !checked) return report_job(checked.error());
    if (auto noted = job.note_begun(); !noted) return report_job(noted.error());
  }
  if (!request.masks.empty() && command.cameras.empty())
    return report(invalid_argument(
        "--masks: needs the cameras of the photos; add --cameras with their transforms.json"));
  if (!command.known.empty()) {
    auto known = read_known_length(command.known);
    if (!known) return report(known.error());
    request.known = *known;
  }
  auto file = read_asset(command.input);
  if (!file) return report(file.error());
  request.name = command.input.filename().string();
  for (const std::string& note : file->notes) log_warn("%s: %s", request.name.c_str(), note.c_str());
  if (request.up.empty() && command.cameras.empty()) request.up = file->frame.up_axis;
  if (!command.cameras.empty()) {
    auto read = read_transforms_file(command.cameras);
    if (!read) return report(read.error());
    request.cameras = std::move(read->views);
  }
  const auto outcome = segment_room(std::move(file->asset), request);
  if (!outcome) return report_job(outcome.error());
  job.progress(kSteps, kSteps);
  const std::string folder = with_shown_paths(request.output.string());
  std::printf("%s: %zu things; run livegs-server %s/room.scene.json\n", folder.c_str(), outcome->things,
              folder.c_str());
  return 0;
}

}  // namespace

void add_segment(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SegmentCommand>();
  CLI::App* command =
      app.add_subcommand("segment", "Find the things in the splat of a room and write each as an asset");
  command->add_option("ROOM", options->input, "Splat of a room")->required();
  command
      ->add_option("--output,-o", options->request.output,
                   "Output folder, new or empty: things, room, scene and page")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--cameras", options->cameras, "transforms.json of the photos (default: views are chosen)")
      ->type_name("FILE");
  command
      ->add_option("--masks", options->request.masks,
                   "Folder of 8-bit label pictures NAME.png of some photos; 0 is the room. Needs --cameras")
      ->type_name("DIR");
  command
      ->add_option("--up", options->request.up,
                   "Up axis of the splat, one of x, -x, y, -y, z, -z (default: of the cameras, else -y)")
      ->type_name("AXIS");
  command->add_option("--scale", options->request.scale, "Metres per unit of the splat")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  command
      ->add_option(
          "--known", options->known,
          "A thing of an earlier run and its longest side in metres, such as part_03=0.21; sets the scale")
      ->type_name("NAME=M")
      ->excludes("--scale");
  add_job_options(*command, options->job);
  command->callback([options, command, &exit_code] {
    exit_code = run_as_job(
        *command, options->job, {&options->input, &options->cameras, &options->request.masks},
        &options->request.output, JobOutput::Folder, [&](Job& job) { return segment(*options, job); });
  });
}

}  // namespace livegs
