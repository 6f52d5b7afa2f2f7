// SPDX-License-Identifier: Apache-2.0
// Time from the start of an analysis to its values, with a model that answers in four seconds, for one object
// and for 20.
//   analyze_bench SCENE OUTPUT_FOLDER
// Loads the scene, draws its views, queries a simulated model in another process over HTTP as `livegs
// analyze` does, and writes analyze.csv. Columns: wall time from the start of the load to the values of the
// first and of the last object, and from the first request to the end of the last object. The exit code is 1
// if the latter exceeds its bound. The objects of the scene are used repeatedly. Requests are sent at the
// default rate, four per second after a burst of eight.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "analysis/model/model_endpoint.h"
#include "bench/support/made_up_endpoint.h"
#include "core/clock.h"
#include "core/log.h"
#include "scene/views/scene_analysis.h"

using namespace livegs;

namespace {

constexpr std::chrono::milliseconds kAnswer{4000};

struct Waited {
  double first_s = 0, loaded_s = 0, all_s = 0, views_s = 0;
  size_t answered = 0;
};

Result<Waited> wait_for(const std::filesystem::path& path, size_t count, const std::string& base_url) {
  auto file = read_scene_file(path);
  if (!file) return file.error();
  const int given = file->objects_size();
  if (given == 0) return invalid_argument(path.string() + ": has no objects");
  v1::Scene many = *file;
  many.clear_objects();
  many.clear_events();
  many.clear_joints();
  for (size_t i = 0; i < count; ++i) {
    v1::Object& object = *many.add_objects();
    object = file->objects(static_cast<int>(i) % given);
    object.set_name(object.name() + " " + std::to_string(i));
    object.mutable_physics()->clear_behavior();
    object.clear_regions();
  }
  Waited waited;
  const int64_t begun_ns = now_ns();
  SceneOptions still;
  still.cut_fragile = false;
  still.built = [&](const SceneObject&) {
    if (waited.first_s == 0) waited.first_s = seconds_from_ns(now_ns() - begun_ns);
    waited.loaded_s = seconds_from_ns(now_ns() - begun_ns);
  };
  const auto scene = Scene::build(many, path.parent_path(), "many", still);
  if (!scene) return scene.error();
  const auto analysis = SceneAnalysis::of(*scene);
  if (!analysis) return analysis.error();
  const auto targets = analysis->targets();
  if (!targets) return targets.error();
  EndpointSettings settings;
  settings.base_url = base_url;
  auto endpoint = open_model_endpoint(std::move(settings));
  if (!endpoint) return endpoint.error();
  AnalysisOptions options;
  options.behind = false;
  const int64_t asked_ns = now_ns();
  const AnalysisSummary summary =
      analyze_scene(*targets, endpoint->get(), analysis->views(), options, [](const auto&) {});
  waited.all_s = seconds_from_ns(now_ns() - asked_ns);
  waited.views_s = summary.slowest_views_s;
  waited.answered = summary.accepted + summary.review;
  if (waited.answered != count)
    return Error{ErrorCode::Internal, "not all were answered: " + summary.failure};
  return waited;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == kServe) return serve_made_up_answers(kAnswer);
  if (argc != 3) {
    std::fprintf(stderr, "usage: analyze_bench SCENE OUTPUT_FOLDER\n");
    return 2;
  }
  set_log_level(LogLevel::Error);
  const auto model = MadeUpEndpoint::start();
  if (!model) {
    std::fprintf(stderr, "%s\n", model.error().message.c_str());
    return 1;
  }
  std::filesystem::create_directories(argv[2]);
  std::ofstream csv(std::filesystem::path(argv[2]) / "analyze.csv");
  csv << "objects,answered,answer_s,load_1min,first_values_s,values_of_all_s,all_s,all_bar_s,slowest_views_"
         "s\n";
  bool within = true;
  for (const auto& [count, bar_s] : {std::pair(size_t{1}, 6), {size_t{20}, 30}}) {
    double load = 0;
    (void)::getloadavg(&load, 1);
    const auto waited = wait_for(argv[1], count, model->base_url());
    if (!waited) {
      std::fprintf(stderr, "%s\n", waited.error().message.c_str());
      return 1;
    }
    char line[160];
    std::snprintf(line, sizeof line, "%zu,%zu,%.0f,%.1f,%.2f,%.2f,%.2f,%d,%.2f", count, waited->answered,
                  1e-3 * static_cast<double>(kAnswer.count()), load, waited->first_s, waited->loaded_s,
                  waited->all_s, bar_s, waited->views_s);
    csv << line << std::endl;
    std::printf("%s\n", line);
    within = within && waited->all_s <= bar_s;
  }
  if (!within) std::fprintf(stderr, "analyze_bench: time exceeds its bound\n");
  return within ? 0 : 1;
}
