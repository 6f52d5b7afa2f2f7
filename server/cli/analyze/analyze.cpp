// SPDX-License-Identifier: GPL-3.0-or-later
#include <google/protobuf/util/json_util.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <tuple>

#include "analysis/gate/answer.h"
#include "analysis/model/endpoint_choice.h"
#include "analysis/physics_file.h"
#include "analysis/run/explain_page.h"
#include "cli/analyze/decide_physics.h"
#include "cli/analyze/parameters_table.h"
#include "cli/commands.h"
#include "cli/input_kind.h"
#include "cli/job/job.h"
#include "cli/output_path.h"
#include "cli/shown_paths.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/help_format.h"
#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "core/written_files.h"
#include "scene/views/scene_analysis.h"
#include "scene/views/target_views.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct AnalyzeCommand {
  fs::path path, explain;
  std::string name, up;
  double scale = 0;
  bool json = false, write = false, no_cache = false;
  int views = 1;
  EndpointChoice endpoint;
  PhysicsDecision decision;
  JobOptions job;
};

// An asset is treated as a scene with one object.
Result<SceneText> scene_of(const AnalyzeCommand& options) {
  if (is_scene_input(options.path)) return read_scene(options.path);
  SceneText alone{{}, "", options.path.filename().string()};
  v1::Object& object = *alone.file.add_objects();
  object.set_asset(fs::absolute(options.path).string());
  object.set_name(options.name);
  object.set_up(options.up);
  if (options.scale > 0) object.set_scale(options.scale);
  return alone;
}

// Names may contain control characters that move a terminal's cursor or change its title.
std::string shown_message(const std::string& message) { return shown_text(message, 1000); }

// Printed while the rest of the scene is loaded and the model is queried.
void print_first(const SceneObject& object) {
  const v1::EstimatedValue& mass = object.physics.mass_kg();
  std::fprintf(stderr, "%s: first estimate %.4g g (%.4g to %.4g) of %s, %s\n",
               shown_line(object.name).c_str(), 1e3 * mass.best(), 1e3 * mass.low(), 1e3 * mass.high(),
               shown_line(object.physics.material()).c_str(),
               v1::Physics::Behavior_Name(object.physics.behavior()).c_str());
}

Result<Scene> load(const AnalyzeCommand& options, bool print_estimates) {
  SceneOptions still;
  still.cut_fragile = false;
  if (print_estimates) still.built = print_first;
  if (is_scene_input(options.path)) return Scene::load(options.path, still);
  const auto alone = scene_of(options);
  return Scene::build(alone->file, alone->folder, alone->name, still);
}

Result<nlohmann::ordered_json> to_json(const v1::PhysicalParameters& parameters) {
  google::protobuf::util::JsonPrintOptions print;
  print.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(parameters, &text, print).ok()) {
    return Error{ErrorCode::Internal, "parameters: could not be converted to JSON"};
  }
  return nlohmann::ordered_json::parse(text);
}

const char* verdict_text(const AnalysisUpdate& update) {
  if (update.turns.empty()) return "offline";
  return update.judgement.verdict == Verdict::Accepted      ? "accepted"
         : update.judgement.verdict == Verdict::NeedsReview ? "needs review"
                                                            : "refused";
}

void print_progress(const std::string& object, const AnalysisUpdate& update) {
  const std::string name = shown_line(object);
  switch (update.stage) {
    case AnalysisStage::Offline:
      break;  // printed by print_first
    case AnalysisStage::Asked:
      std::fprintf(stderr, "%s: request sent\n", name.c_str());
      break;
    case AnalysisStage::Repaired:
      std::fprintf(stderr, "%s: answer rejected, request repeated: %s\n", name.c_str(),
                   shown_message(update.turns.back().error).c_str());
      break;
    case AnalysisStage::Finished:
      std::fprintf(stderr, "%s: %s%s%s%s\n", name.c_str(), verdict_text(update),
                   update.cached ? ", from the cache" : "", update.judgement.message.empty() ? "" : ": ",
                   shown_message(update.judgement.message).c_str());
  }
}

struct Analysed {
  const SceneAnalysis::Object* object = nullptr;
  AnalysisUpdate update;
  v1::PhysicalParameters parameters;
};

// Returns the resulting parameters of the object. The new answer replaces the one in the sidecar; manual
// edits and values of the scene file have priority.
Result<v1::PhysicalParameters> outcome(const SceneAnalysis::Object& object, const AnalysisUpdate& update) {
  v1::PhysicsFile file;
  if (!object.physics_file.empty()) {
    auto kept = read_physics_file(object.physics_file);
    if (!kept) return kept.error();
    file = std::move(*kept);
  }
  if (update.judgement.verdict == Verdict::Accepted) *file.mutable_physics() = update.parameters;
  std::string note;
  auto layered = layered_physics(file, object.written, *object.target.facts, note);
  if (!note.empty()) log_warn("%s: %s", shown_line(object.name).c_str(), note.c_str());
  if (layered) *layered->mutable_longest_side_m() = object.target.offline.longest_side_m();
  return layered;
}

// Stores an answer in the sidecar. An offline estimate never overwrites the answer of a model.
Result<void> keep(const SceneAnalysis::Object& object, const AnalysisUpdate& update, bool asked) {
  const std::string name = shown_line(object.name);
  if (object.physics_file.empty()) {
    std::fprintf(stderr, "%s: the object has no sidecar file; write the values into the scene file\n",
                 name.c_str());
    return {};
  }
  if (update.judgement.verdict == Verdict::NeedsReview) {
    std::fprintf(stderr, "%s: saved as a proposal; apply it with --accept \"%s\"\n", name.c_str(),
                 name.c_str());
    return log_proposal(object.physics_file, update.judgement.proposal, update.record);
  }
  if (update.judgement.verdict != Verdict::Accepted) {
    auto present = read_physics_file(object.physics_file);
    if (!present) return present.error();
    if (asked || !present->analysis().model().empty()) return {};
  }
  auto kept = apply_analysis(object.physics_file, update.parameters, update.record);
  if (!kept) return kept.error();
  std::fprintf(stderr, "%s: saved in %s; reload the scene on a running server to apply it\n", name.c_str(),
               shown_message(with_shown_paths(object.physics_file.string())).c_str());
  return {};
}

// Draws the views of each object once; the page shows the views that were sent to the model. Any thread, but
// only one thread at a time per object.
class KeptViews {
 public:
  explicit KeptViews(TargetViews make) : make_(std::move(make)) {}

  Result<std::vector<TargetView>> of(uint32_t object_id, int count) {
    {
      std::lock_guard lock(mutex_);
      if (const auto found = kept_.find(object_id); found != kept_.end()) return found->second;
    }
    auto made = make_(object_id, count, {});
    std::lock_guard lock(mutex_);
    return kept_.emplace(object_id, std::move(made)).first->second;
  }

 private:
  TargetViews make_;
  std::mutex mutex_;  // guards kept_
  std::map<uint32_t, Result<std::vector<TargetView>>> kept_;
};

// Writes the HTML page of an object. If drawing failed, the page has no pictures.
Result<void> explain(const fs::path& folder, const SceneAnalysis::Object& object,
                     const AnalysisUpdate& update, const Result<std::vector<TargetView>>& views) {
  std::error_code made;
  fs::create_directories(folder, made);
  if (!views)
    log_warn("%s: views could not be drawn: %s", shown_line(object.name).c_str(),
             shown_message(views.error().message).c_str());
  const fs::path page = folder / (object_file_name(object.name) + ".html");
  std::vector<TargetView> shown = views ? *views : std::vector<TargetView>{};
  for (size_t i = 0; i < shown.size() && update.parameters.parts_size() > 0; ++i) {
    auto coloured = part_pictures(shown[i], *object.target.facts, update.parameters);
    if (!coloured) return coloured.error();
    for (AnalysisImage& image : *coloured) shown[i].images.push_back(std::move(image));
  }
  auto written = write_file_atomically(page, explain_page(object.target, update, shown));
  if (written) {
    note_written(page);
    std::fprintf(stderr, "written: %s\n", with_shown_paths(page.string()).c_str());
  }
  return written;
}

Result<std::string> result_text(const AnalyzeCommand& options, const std::vector<Analysed>& all) {
  const bool scene = is_scene_input(options.path);
  if (options.json) {
    nlohmann::ordered_json objects = nlohmann::ordered_json::array();
    for (const Analysed& one : all) {
      auto json = to_json(one.parameters);
      if (!json) return json.error();
      if (!scene) return json->dump(1) + "\n";
      objects.push_back({{"object", one.object->name},
                         {"verdict", verdict_text(one.update)},
                         {"message", one.update.judgement.message},
                         {"model", one.update.record.model()},
                         {"physics", std::move(*json)}});
    }
    return nlohmann::ordered_json{{"objects", std::move(objects)}}.dump(1) + "\n";
  }
  std::string text = scene ? table_head() : "";
  for (const Analysed& one : all)
    text += scene ? table_row(shown_line(one.object->name), one.parameters) : parameters_text(one.parameters);
  return text;
}

// Refuses options for single assets if the input is a scene file, which sets them per object.
Result<void> check_options(const AnalyzeCommand& options) {
  if (!is_scene_input(options.path)) return {};
  for (const auto& [option, field, given] : {std::tuple("--name", "name", !options.name.empty()),
                                             {"--scale", "scale", options.scale > 0},
                                             {"--up", "up", !options.up.empty()}}) {
    if (given) {
      return invalid_argument(std::string(option) +
                              ": is only for a single asset; in a scene file, give the object a \"" + field +
                              "\"");
    }
  }
  return {};
}

int analyze(const AnalyzeCommand& options, Job& job) {
  if (auto checked = check_options(options); !checked) return report(checked.error());
  if (auto checked = check_output_folder(options.explain); !checked) return report_job(checked.error());
  if (options.decision.any()) {
    job.leave_unmarked();
    const auto scene = scene_of(options);
    if (!scene) return report(scene.error());
    const int code = decide_physics(options.decision, scene->file, scene->folder, scene->name);
    if (code == 0) job.inputs_changed();
    return code;
  }
  auto endpoint = choose_endpoint(options.endpoint);
  if (!endpoint) return report(endpoint.error());
  set_log_level(LogLevel::Warn);
  auto scene = load(options, *endpoint != nullptr);
  if (!scene) return report(scene.error());
  const bool explained = !options.explain.empty();
  auto analysis = SceneAnalysis::of(*scene, *endpoint != nullptr || explained);
  if (!analysis) return report(analysis.error());
  const auto targets =
      analysis->targets(is_scene_input(options.path) ? std::vector<std::string>{}
                                                     : std::vector<std::string>{analysis->objects()[0].name});
  if (!targets) return report(targets.error());
  const auto object_of = [&](uint32_t id) {
    return &*std::find_if(analysis->objects().begin(), analysis->objects().end(),
                          [&](const auto& one) { return one.target.object_id == id; });
  };

  const bool replays = !options.endpoint.recorded.empty() || !options.endpoint.record.empty();
  const bool keeps_answers = *endpoint && job.keeps_state() && !options.no_cache && !replays;
  fs::path answers;
  if (keeps_answers) {
    answers = fs::temp_directory_path() / "answers";
    if (auto kept = job.last_files(answers); !kept) return report_job(kept.error());
  } else if (!options.no_cache && !replays && !cache_folder().empty()) {
    answers = cache_folder() / "answers";
  }
  AnswerCache cache(answers);
  AnalysisOptions asked;
  asked.views = options.views;
  asked.cache = &cache;
  asked.behind = false;  // the user is waiting
  asked.neighbours = analysis->neighbours(*targets);
  KeptViews views(analysis->views());
  // With an endpoint, views are drawn while requests for other objects are pending.
  for (size_t i = 0; explained && !*endpoint && i < targets->size(); ++i) {
    std::fprintf(stderr, "%s: drawing views, %zu of %zu\n",
                 shown_line(object_of((*targets)[i].object_id)->name).c_str(), i + 1, targets->size());
    (void)views.of((*targets)[i].object_id, options.views);
  }
  std::vector<Analysed> all(targets->size());
  size_t finished = 0;
  job.progress(0, all.size());
  Result<void> all_kept;
  const auto looks = [&](uint32_t id, int count, std::stop_token) { return views.of(id, count); };
  const AnalysisSummary summary =
      analyze_scene(*targets, endpoint->get(), looks, asked, [&](const AnalysisUpdate& update) {
        Analysed& one = all[update.index];
        one.object = object_of(update.object_id);
        one.update = update;
        if (*endpoint) print_progress(one.object->name, update);
        if (update.stage != AnalysisStage::Finished) return;
        job.progress(++finished, all.size());
        if (keeps_answers) {
          if (auto kept = job.keep_files(answers); !kept)
            log_warn("%s", with_shown_paths(kept.error().message).c_str());
        }
        // Saved at once, so that paid answers survive an interruption.
        if (options.write) {
          if (auto kept = keep(*one.object, update, *endpoint != nullptr); !kept && all_kept) all_kept = kept;
        }
      });
  for (Analysed& one : all) {
    auto parameters = outcome(*one.object, one.update);
    if (!parameters) return report(parameters.error());
    one.parameters = std::move(*parameters);
    if (explained) {
      const auto seen = views.of(one.object->target.object_id, options.views);
      AnalysisUpdate shown = one.update;
      shown.parameters = one.parameters;  // the same values as in the table
      if (auto written = explain(options.explain, *one.object, shown, seen); !written)
        return report(written.error());
    }
  }
  const auto text = result_text(options, all);
  if (!text) return report(text.error());
  job.print(*text);
  if (!all_kept) return report_job(all_kept.error());
  if (*endpoint) {
    std::fprintf(
        stderr,
        "%zu objects: %zu accepted, %zu for review, %zu refused, %zu without an answer; %lld + %lld tokens",
        summary.objects, summary.accepted, summary.review, summary.refused, summary.failed,
        static_cast<long long>(summary.prompt_tokens), static_cast<long long>(summary.completion_tokens));
    if (summary.cost_usd > 0) std::fprintf(stderr, ", %.4f USD", summary.cost_usd);
    std::fprintf(stderr, "; views took at most %.1f s per object", summary.slowest_views_s);
    std::fputc('\n', stderr);
    // A model was configured, but no request was answered.
    if (summary.failed == summary.objects && summary.objects > 0) {
      const Error unanswered{ErrorCode::Unavailable,
                             summary.failure + " (the printed values are offline estimates)"};
      return replays ? report(unanswered) : report_job(unanswered);
    }
    if (summary.failed > 0) job.leave_unmarked();  // a repetition asks for these again
  }
  if (options.write) job.inputs_changed();
  return 0;
}

}  // namespace

void add_analyze(CLI::App& app, int& exit_code) {
  const auto folder_or_address = [](std::string text) {
    return is_store_url(text) ? std::string() : CLI::ExistingDirectory(text);
  };
  auto options = std::make_shared<AnalyzeCommand>();
  CLI::App* command =
      app.add_subcommand("analyze", "Estimate the physical parameters of objects, with ranges and reasons");
  command->add_option("SCENE_OR_ASSET", options->path, "A *.scene.json, a folder of assets, or a splat asset")
      ->required();
  command->add_option("--name", options->name, "Name of the object (default: file name)");
  command->add_option("--scale", options->scale, "Metres per unit of the asset (default: guessed)")
      ->check([](const std::string& text) {
        const double scale = std::strtod(text.c_str(), nullptr);
        return scale > 0 && std::isfinite(scale) ? "" : "is " + text + "; it must be above 0";
      });
  command->add_option("--up", options->up, "Up axis of the asset, one of x, -x, y, -y, z, -z")
      ->default_str("-y");
  command->add_flag("--json", options->json,
                    "Print JSON (livegs.v1.PhysicalParameters; for a scene, one per object)");
  command->add_option(
      "--endpoint", options->endpoint.url,
      "URL of a server with an OpenAI-compatible chat completions API (default: the value of the variable "
      "OPENAI_BASE_URL, with OPENAI_API_KEY; without a URL, offline estimates are used)");
  command->add_option("--model", options->endpoint.model,
                      "Name of the model (default: the value of the variable LIVEGS_MODEL)");
  command
      ->add_option("--recorded", options->endpoint.recorded,
                   "Replay the answers in this folder instead of calling a model")
      ->check(folder_or_address);
  command
      ->add_option("--record-answers", options->endpoint.record,
                   "Save the answers in this folder, for --recorded")
      ->check([](const std::string& text) {
        return is_store_url(text) ? shown_url(text) + ": is an address; give a folder of this machine" : "";
      });
  command
      ->add_option("--prompts", options->endpoint.prompts,
                   "Folder of prompt files that replace built-in prompts with the same name")
      ->check(folder_or_address);
  command->add_option(
      "--price", options->endpoint.price,
      "US dollars per million tokens sent and received, as IN,OUT, to compute the cost (default: the value "
      "of the variable LIVEGS_PRICE)");
  command
      ->add_option("--model-deadline", options->endpoint.deadline_s,
                   "Time limit of one question including retries (default: the value of the variable "
                   "LIVEGS_MODEL_DEADLINE_S, else 60, or 300 for Ollama and llama.cpp)")
      ->check(CLI::Range(1.0, 3600.0))
      ->type_name("SECONDS");
  command->add_flag("--web-search", options->endpoint.web_search,
                    "Allow one web search per object if the endpoint supports it (default: off)");
  command
      ->add_option("--views", options->views,
                   "Number of questions per object, from different views; 3 answers are combined by vote")
      ->check(CLI::IsMember({1, 3}));
  command->add_flag("--offline", options->endpoint.offline, "Do not call a model, even if one is configured");
  command->add_flag("--no-cache", options->no_cache, "Do not use cached answers");
  command->add_option(
      "--explain", options->explain,
      "Write one HTML page per object to this folder: views, prompt, raw answer, checks and "
      "values. Pages are NAME.html; bytes other than letters, digits, - and _ are percent-encoded");
  command->add_flag("--write", options->write, "Save the values next to the assets, as NAME.physics.json");
  CLI::Option* accept =
      command->add_option("--accept", options->decision.accept,
                          "Apply the proposal of the last --write for this OBJECT, without a model");
  CLI::Option* decline = command->add_option("--decline", options->decision.decline,
                                             "Discard the proposal for this OBJECT and keep its values");
  CLI::Option* undo =
      command->add_option("--undo", options->decision.undo, "Undo the last change of this OBJECT's values");
  CLI::Option* redo =
      command->add_option("--redo", options->decision.redo, "Redo the change that --undo reverted");
  group_options(*command, "Object", {{"--name", "NAME"}, {"--scale", "METRES"}, {"--up", "AXIS"}});
  group_options(*command, "Model",
                {{"--offline", ""},
                 {"--endpoint", "URL"},
                 {"--model", "NAME"},
                 {"--views", ""},
                 {"--web-search", ""},
                 {"--model-deadline", "SECONDS"},
                 {"--price", "IN,OUT"},
                 {"--prompts", "FOLDER"},
                 {"--recorded", "FOLDER"},
                 {"--record-answers", "FOLDER"},
                 {"--no-cache", ""}});
  group_options(*command, "Output", {{"--json", ""}, {"--explain", "FOLDER"}, {"--write", ""}});
  group_options(
      *command, "Decisions",
      {{"--accept", "OBJECT"}, {"--decline", "OBJECT"}, {"--undo", "OBJECT"}, {"--redo", "OBJECT"}});
  decline->excludes(accept);
  undo->excludes(accept)->excludes(decline);
  redo->excludes(accept)->excludes(decline)->excludes(undo);
  add_job_options(*command, options->job);
  command->callback([options, command, &exit_code] {
    const std::string given = shown_url(options->path.string());
    exit_code = options->write && is_store_url(given) && !has_ending(given, ".scene.json")
                    ? report(invalid_argument(given + ": has no place for the values of --write; give the "
                                                      "address of a scene that livegs publish stored"))
                    : run_as_job(*command, options->job,
                                 {&options->path, &options->endpoint.prompts, &options->endpoint.recorded},
                                 &options->explain, JobOutput::Folder,
                                 [&](Job& job) { return analyze(*options, job); });
  });
}

}  // namespace livegs
