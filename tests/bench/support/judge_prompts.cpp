// SPDX-License-Identifier: Apache-2.0
#include "bench/support/judge_prompts.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "analysis/model/endpoint_choice.h"
#include "core/file.h"
#include "core/log.h"
#include "scene/views/scene_analysis.h"
#include "server/analysis/estimate/known_objects.h"
#include "server/analysis/model/prompt_judgement.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct Request {
  fs::path before, after, keep;
  std::string name = "none";
  EndpointChoice endpoint;
};

bool parse(const std::vector<std::string>& words, Request& request) {
  if (words.size() < 2 || words.size() % 2 != 0) return false;
  request.before = words[0];
  request.after = words[1];
  for (size_t i = 2; i < words.size(); i += 2) {
    const std::string& value = words[i + 1];
    if (words[i] == "--recorded") {
      request.endpoint.recorded = value;
    } else if (words[i] == "--record") {
      request.endpoint.record = value;
    } else if (words[i] == "--keep") {
      request.keep = value;
    } else if (words[i] == "--name" &&
               (value == "label" || value == "noun" || value == "file" || value == "none")) {
      request.name = value;
    } else {
      return false;
    }
  }
  return true;
}

// An object in its own scene on a floor, as for `livegs analyze`, and its pictures.
struct Seen {
  JudgedObject object;
  std::vector<TargetView> views;
};

Result<Seen> see(const KnownObject& known, uint32_t id, const std::string& given) {
  v1::Scene file;
  v1::Object& thing = *file.add_objects();
  thing.set_asset(known.asset.string());
  thing.set_name(known.id);
  thing.set_up("z");
  thing.set_scale(1);
  SceneOptions still;
  still.cut_fragile = false;
  const auto scene = Scene::build(file, "", known.id, still);
  if (!scene) return scene.error();
  const auto analysis = SceneAnalysis::of(*scene);
  if (!analysis) return analysis.error();
  Seen seen;
  seen.object.id = known.id;
  seen.object.target = analysis->objects().front().target;
  auto views = analysis->views()(seen.object.target.object_id, 1, {});
  if (!views) return views.error();
  seen.views = std::move(*views);
  ObjectFacts facts = *seen.object.target.facts;
  facts.name = given;
  seen.object.target.object_id = id;
  seen.object.target.offline = estimate_offline(facts);
  seen.object.target.facts = std::make_shared<ObjectFacts>(std::move(facts));
  seen.object.mass_kg = known.mass_kg;
  seen.object.behavior = known.elastic ? v1::Physics::ELASTIC : v1::Physics::RIGID;
  return seen;
}

Result<PromptTrial> trial_with(const Request& request, const fs::path& prompts,
                               std::span<const JudgedObject> objects, const TargetViews& views) {
  EndpointChoice choice = request.endpoint;
  choice.prompts = prompts;
  const auto endpoint = choose_endpoint(choice);
  if (!endpoint) return endpoint.error();
  if (!*endpoint) {
    return invalid_argument("no endpoint; set OPENAI_BASE_URL and LIVEGS_MODEL, or use --recorded ANSWERS");
  }
  return try_prompts(objects, **endpoint, views);
}

int report(const Error& error) {
  std::fprintf(stderr, "mass_harness: %s\n", error.message.c_str());
  return 1;
}

}  // namespace

int judge_prompts(const std::vector<std::string>& words) {
  Request request;
  if (!parse(words, request)) {
    std::fprintf(stderr, "usage: mass_harness %s\n", kJudgeUsage);
    return 2;
  }
  set_log_level(LogLevel::Error);
  // Reports errors in the folders before any request.
  for (const fs::path& folder : {request.before, request.after}) {
    if (const auto files = prompt_files(folder); !files) return report(files.error());
  }
  const auto& known = known_objects(KnownForm::Splats);
  if (known.empty()) return report(not_found("shared/data/ycb: not found; it must be next to this checkout"));
  std::vector<JudgedObject> objects;
  std::map<uint32_t, std::vector<TargetView>> views;
  for (const KnownObject& one : known) {
    std::fprintf(stderr, "\rviews of %zu of %zu objects", objects.size() + 1, known.size());
    const std::string given = request.name == "label"  ? one.label
                              : request.name == "noun" ? one.noun
                              : request.name == "file" ? one.id
                                                       : "";
    auto seen = see(one, static_cast<uint32_t>(objects.size() + 1), given);
    if (!seen) return report(seen.error());
    views[seen->object.target.object_id] = std::move(seen->views);
    objects.push_back(std::move(seen->object));
  }
  std::fputc('\n', stderr);
  const TargetViews look = [&](uint32_t id, int, std::stop_token) { return views.at(id); };
  const auto before = trial_with(request, request.before, objects, look);
  if (!before) return report(before.error());
  const auto after = trial_with(request, request.after, objects, look);
  if (!after) return report(after.error());

  const PromptComparison comparison = compare_prompts(*before, *after);
  std::printf(
      "model %s%s, %zu objects, name given: %s\n", after->model.c_str(),
      after->model.starts_with(kMadeUpModel) ? " (simulated for a test; not the figures of a model)" : "",
      objects.size(), request.name.c_str());
  std::printf("%-16s %10s %10s %10s  %-22s\n", "", before->prompt_version.substr(0, 10).c_str(),
              after->prompt_version.substr(0, 10).c_str(), "change", "95 % interval");
  for (const PromptMeasure& row : comparison.measures) {
    std::printf("%-16s %10.3f %10.3f %+10.3f  %+.3f to %+.3f  %s\n", row.name, row.before, row.after,
                row.change.value, row.change.low, row.change.high,
                row.verdict == PromptVerdict::Same ? "" : verdict_name(row.verdict));
  }
  for (const PromptTrial* trial : {&*before, &*after}) {
    std::printf("%s: %lld + %lld tokens, %.4f USD\n", trial->prompt_version.c_str(),
                static_cast<long long>(trial->prompt_tokens),
                static_cast<long long>(trial->completion_tokens), trial->cost_usd);
  }
  std::printf("%s is %s\n", request.after.c_str(),
              comparison.verdict == PromptVerdict::Same ? "neither better nor worse on these objects"
                                                        : verdict_name(comparison.verdict));
  if (!request.keep.empty()) {
    const auto text = judgement_text(request.before, request.after, *before, *after, request.name);
    if (!text) return report(text.error());
    if (auto written = write_file_atomically(request.keep, *text); !written) return report(written.error());
  }
  return comparison.verdict == PromptVerdict::Worse ? 3 : 0;
}

}  // namespace livegs
