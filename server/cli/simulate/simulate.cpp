// SPDX-License-Identifier: GPL-3.0-or-later
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "baseline/elastic_solvers.h"
#include "cli/choose_device.h"
#include "cli/commands.h"
#include "cli/output_path.h"
#include "cli/simulate/simulation_record.h"
#include "core/clock.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel_for.h"
#include "core/percentile.h"
#include "core/text/help_format.h"
#include "core/written_files.h"
#include "device/choose_physics.h"
#include "scene/build/elastic_report.h"
#include "splat/camera_file.h"
#include "splat/frame_bounds.h"
#include "splat/tiles/image_rasteriser.h"

namespace livegs {
namespace {

struct SimulateCommand {
  std::filesystem::path scene, output, camera;
  double seconds = 2.0;
  double rate_hz = 0;
  int substeps = 0;
  std::string solver = "cells", skinning = "lattice", device = "auto", physics = "cpu";
  bool particles = false, kernels = false, no_sleep = false, drop = false, draw = false, no_shadows = false;
  bool offline = false;  // accepted as by the other commands, without effect
  int every = 1;
  uint64_t seed = 1;
};

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void write_stiffness(const MaterialAccuracy& accuracy, nlohmann::json& summary) {
  summary["band"] = name_of(accuracy.band);
  summary["youngs_modulus_pa"] = accuracy.youngs_modulus_pa;
  summary["reached_youngs_modulus_pa"] = accuracy.reached_youngs_modulus_pa;
  summary["modulus_ratio_low"] = accuracy.modulus_ratio_low;
  summary["modulus_ratio_high"] = accuracy.modulus_ratio_high;
  summary["modulus_ratio_across"] = accuracy.modulus_ratio_across;
  summary["clipped"] = accuracy.clipped;
}

// Returns warnings about the state after the run, such as an elastic body that diverged and was reset.
std::vector<std::string> warnings_of(const Scene& scene, const SceneObject& object) {
  const ElasticBody* body = scene.world().elastic_body(object.id);
  if (!body) return object.all_warnings();
  std::vector<std::string> all = object.warnings;
  for (std::string& warning : accuracy_warnings(body->accuracy())) all.push_back(std::move(warning));
  return all;
}

nlohmann::json object_summary(const Scene& scene, const SceneObject& object) {
  nlohmann::json summary = {{"name", object.name},
                            {"kernels", object.asset->size()},
                            {"behavior", v1::Physics::Behavior_Name(object.physics.behavior())},
                            {"behavior_reason", object.physics.behavior_reason()},
                            {"material", object.physics.material()},
                            {"mass_kg", object.mass_kg},
                            {"surface", object.surface_note},
                            {"warnings", warnings_of(scene, object)}};
  if (object.fragility) {
    summary["fragile"] = {{"pieces", object.fragility->pieces},
                          {"bodies", object.fragility->bodies},
                          {"break_impulse_n_s", object.fragility->break_impulse_n_s},
                          {"drop_height_m", object.fragility->drop_height_m}};
  }
  if (object.elastic) {
    const ElasticAccuracy& accuracy = *object.elastic;
    summary["particles"] = accuracy.particles;
    summary["nodes"] = accuracy.nodes;
    summary["cells"] = accuracy.cells;
    summary["bytes"] = accuracy.bytes;
    summary["cell_width_m"] = accuracy.cell_width_m;
    summary["substeps"] = accuracy.substeps;
    summary["courant"] = accuracy.courant;
    write_stiffness(accuracy, summary);
    for (const RegionAccuracy& region : accuracy.regions) {
      nlohmann::json& own = summary["regions"].emplace_back();
      own["name"] = region.name;
      write_stiffness(region, own);
    }
  }
  return summary;
}

struct PhaseTimes {
  double load_ms = 0, step_ms = 0, elastic_ms = 0, rigid_ms = 0, pose_ms = 0, draw_ms = 0, write_ms = 0;
  std::vector<double> steps_ms;
};

nlohmann::json run_summary(const SimulateCommand& options, const Scene& scene, const PhaseTimes& times,
                           uint64_t frames) {
  const WorldSettings& settings = scene.world().settings();
  nlohmann::json summary;
  summary["version"] = LIVEGS_VERSION;
  summary["scene"] = scene.name();
  summary["settings"] = {{"rate_hz", settings.rate_hz},  {"substeps", settings.substeps},
                         {"seconds", options.seconds},   {"elastic_solver", options.solver},
                         {"skinning", options.skinning}, {"sleep", settings.sleep},
                         {"threads", thread_count()},    {"seed", options.seed}};
  size_t nodes = 0, particles = 0, kernels = 0, bodies = 0;
  double node_substeps = 0;
  summary["objects"] = nlohmann::json::array();
  summary["warnings"] = nlohmann::json::array();
  for (const SceneObject& object : scene.objects()) {
    kernels += object.asset->size();
    if (object.environment) continue;
    summary["objects"].push_back(object_summary(scene, object));
    for (const std::string& warning : warnings_of(scene, object)) {
      summary["warnings"].push_back(object.name + ": " + warning);
    }
    if (object.elastic) {
      nodes += object.elastic->nodes;
      particles += object.elastic->particles;
      node_substeps +=
          static_cast<double>(object.elastic->nodes) * object.elastic->substeps * static_cast<double>(frames);
    } else {
      bodies += object.fragility ? object.fragility->bodies : 1;
    }
  }
  summary["counts"] = {{"frames", frames},   {"objects", scene.objects().size()},
                       {"kernels", kernels}, {"rigid_bodies", bodies},
                       {"nodes", nodes},     {"particles", particles}};
  summary["times_ms"] = {{"load", times.load_ms},
                         {"step", times.step_ms},
                         {"elastic", times.elastic_ms},
                         {"rigid", times.rigid_ms},
                         {"pose", times.pose_ms},
                         {"draw", times.draw_ms},
                         {"write", times.write_ms},
                         {"step_p50", percentile(times.steps_ms, 0.5)},
                         {"step_p99", percentile(times.steps_ms, 0.99)}};
  summary["ns_per_node_substep"] = node_substeps > 0 ? times.elastic_ms * 1e6 / node_substeps : 0.0;
  summary["peak_memory_mb"] = peak_memory_mb();
  return summary;
}

int run(const SimulateCommand& options) {
  // NaN passes the range check of the option parser.
  if (!std::isfinite(options.seconds) || !std::isfinite(options.rate_hz)) {
    return report(invalid_argument("--seconds, --rate: must be finite numbers"));
  }
  if (auto checked = check_output_folder(options.output); !checked) return report(checked.error());
  SceneOptions scene_options;
  if (options.rate_hz > 0) scene_options.rate_hz = options.rate_hz;
  if (options.substeps > 0) scene_options.substeps = options.substeps;
  scene_options.make_elastic = elastic_solvers().at(options.solver);
  scene_options.sleep = !options.no_sleep;
  scene_options.seed = options.seed;
  scene_options.drop = options.drop;

  PhaseTimes times;
  int64_t mark_ns = now_ns();
  const auto lap = [&mark_ns] {
    const int64_t before = mark_ns;
    mark_ns = now_ns();
    return milliseconds_from_ns(mark_ns - before);
  };
  auto physics = choose_physics(options.physics);
  if (!physics) return report(physics.error());
  set_elastic_device(*physics);
  auto scene = Scene::load(options.scene, scene_options);
  if (!scene) return report(scene.error());
  std::error_code error;
  std::filesystem::create_directories(options.output, error);
  if (error)
    return report({ErrorCode::PermissionDenied, options.output.string() + ": cannot be created: " +
                                                    error.message() + "; give another folder with --output"});
  std::optional<Camera> camera;
  if (!options.camera.empty()) {
    auto read = read_camera_file(options.camera);
    if (!read) return report(read.error());
    camera = *read;
  } else if (options.draw) {
    camera = frame_bounds(scene->bounds_m(), 640, 480);
  }
  auto record = SimulationRecord::open(options.output, {options.particles, options.kernels});
  if (!record) return report(record.error());
  times.load_ms = lap();

  SceneDrawing drawing(options.skinning == "lattice" ? Skinning::Lattice : Skinning::LivegsV1);
  drawing.keep_deformation_gradients(options.kernels);
  drawing.set_shadows(camera.has_value() && !options.no_shadows);
  auto device = camera ? choose_device(options.device) : std::unique_ptr<Backend>();
  if (!device) return report(device.error());
  ImageRasteriser rasteriser(*std::move(device));
  Image image;
  const double rate_hz = scene->world().settings().rate_hz;
  const auto frames = static_cast<uint64_t>(std::llround(options.seconds * rate_hz));
  int64_t logged_ns = mark_ns;
  for (uint64_t frame = 0; frame <= frames; ++frame) {
    if (frame > 0) {
      scene->step();
      const StepTimes step = scene->world().last_times();
      times.elastic_ms += step.elastic_ms;
      times.rigid_ms += step.rigid_ms;
      times.steps_ms.push_back(lap());
      times.step_ms += times.steps_ms.back();
    }
    const bool drawn_now = camera && frame % static_cast<uint64_t>(options.every) == 0;
    if (drawn_now || options.kernels) {
      auto drawn = drawing.pose(*scene);
      if (!drawn) return report(drawn.error());
      times.pose_ms += lap();
      if (drawn_now) {
        rasteriser.draw(*drawn, *camera, drawing.options(), image);
        char name[32];
        std::snprintf(name, sizeof name, "frame_%04lu.png", frame);
        if (auto written = write_png(options.output / name, image, false, 3); !written)
          return report(written.error());
        note_written(options.output / name);
        times.draw_ms += lap();
      }
    }
    record->write(*scene, drawing);
    times.write_ms += lap();
    if (mark_ns - logged_ns > 2'000'000'000) {
      logged_ns = mark_ns;
      log_info("%.0f %%: %.2f s of %.2f s simulated",
               100.0 * static_cast<double>(frame) / static_cast<double>(frames),
               static_cast<double>(frame) / rate_hz, options.seconds);
    }
  }
  if (auto closed = record->close(); !closed) return report(closed.error());
  const nlohmann::json summary = run_summary(options, *scene, times, frames);
  if (auto written = write_file_atomically(options.output / "summary.json", summary.dump(2) + "\n");
      !written) {
    return report(written.error());
  }
  note_written(options.output / "summary.json");
  std::fputs(written_files_text().c_str(), stdout);
  std::printf("%s: %lu frames at %g Hz, step p50 %.2f ms, p99 %.2f ms\n", options.output.c_str(), frames,
              rate_hz, percentile(times.steps_ms, 0.5), percentile(times.steps_ms, 0.99));
  return 0;
}

}  // namespace

void add_simulate(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SimulateCommand>();
  CLI::App* command =
      app.add_subcommand("simulate", "Simulate a scene offline and write its motion to files");
  command->add_option("SCENE", options->scene, "*.scene.json or folder of assets")->required();
  command->add_option("--seconds", options->seconds, "Simulated time")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  command
      ->add_option("--output,-o", options->output, "Output folder for CSV files, pictures and summary.json")
      ->required();
  command->add_option("--rate", options->rate_hz, "Ticks per second (default: from the scene)")
      ->check(CLI::Range(1.0, 2000.0));
  command->add_option("--substeps", options->substeps, "Substeps per tick (default: from the scene)")
      ->check(CLI::Range(1, 1024));
  command
      ->add_option(
          "--elastic-solver", options->solver,
          "cells; livegs-v1 (solver of the LIVE-GS paper); livegs-v1-steady (livegs-v1 with a stiffness "
          "independent of the substep)")
      ->check(CLI::IsMember(elastic_solvers()))
      ->capture_default_str();
  command->add_option("--physics", options->physics, kPhysicsHelp)
      ->check(CLI::IsMember(kPhysicsChoices))
      ->capture_default_str();
  command
      ->add_option("--skinning", options->skinning,
                   "lattice; or livegs-v1, the skinning of the LIVE-GS paper")
      ->check(CLI::IsMember({"lattice", "livegs-v1"}))
      ->capture_default_str();
  command->add_flag("--particles", options->particles, "Write particles.csv");
  command->add_flag("--kernels", options->kernels, "Write kernels.csv");
  command->add_option("--render", options->camera, "Render PNGs with this camera file");
  add_device_option(*command, options->device);
  command->add_flag("--no-shadows", options->no_shadows, "Draw objects without contact and soft shadows");
  command->add_flag("--pictures", options->draw, "Render PNGs of the whole scene from the front");
  command->add_option("--every", options->every, "Render every Nth frame")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of the pieces of fragile objects")
      ->capture_default_str();
  command->add_flag("--no-sleep", options->no_sleep, "Disable the sleep of bodies at rest");
  command->add_flag("--offline", options->offline,
                    "No effect, because simulate does not use a language model");
  command->add_flag("--drop", options->drop,
                    "Folder of assets: drop the objects onto the floor instead of placing them on it");
  group_options(*command, "Simulation",
                {{"--seconds", "SECONDS"},
                 {"--rate", "HZ"},
                 {"--substeps", ""},
                 {"--elastic-solver", ""},
                 {"--physics", ""},
                 {"--skinning", ""},
                 {"--seed", ""},
                 {"--no-sleep", ""},
                 {"--drop", ""},
                 {"--offline", ""}});
  group_options(*command, "Output",
                {{"--output", "FOLDER"},
                 {"--particles", ""},
                 {"--kernels", ""},
                 {"--pictures", ""},
                 {"--render", "CAMERA_FILE"},
                 {"--every", ""}});
  command->footer(
      "Examples:\n"
      "  livegs simulate scene/sample.scene.json --seconds 2 -o out/sim\n"
      "  livegs simulate FOLDER --drop --pictures --every 3 -o out/fall");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
