// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/run/ask_model.h"

#include <algorithm>

#include "analysis/model/fact_slots.h"
#include "core/content_hash.h"
#include "core/text/shown_text.h"

namespace livegs {
namespace {

constexpr const char* kSchema = "livegs.analysis/1";

std::string text_hash(const std::string& text) {
  return content_hash(std::as_bytes(std::span(text.data(), text.size())));
}

std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// Each part is preceded by its length, so that different questions have different encodings.
void add(std::string& text, const std::string& part) {
  text += std::to_string(part.size()) + ":" + part + "\n";
}

// Hash of all inputs of the answer.
std::string question_hash(const AnalysisQuestion& question, const AnalysisTarget& target,
                          const std::vector<SceneObjectFacts>& neighbours, const EndpointState& endpoint,
                          const std::string& prompt_version) {
  std::string text;
  for (const std::string& part : {std::string(kSchema), prompt_version, endpoint.name, endpoint.model})
    add(text, part);
  for (const auto& [slot, value] : question.slots) {
    add(text, slot);
    add(text, value);
  }
  for (const AnalysisImage& image : question.images) {
    add(text, image.caption);
    add(text, text_hash(image.bytes));
  }
  const MeshFacts& mesh = target.facts->mesh;
  for (const double value :
       {mesh.volume_m3, mesh.area_m2, mesh.mean_wall_m, mesh.hull_volume_m3, mesh.openness}) {
    add(text, three_digits(value));
  }
  for (const SceneObjectFacts& one : neighbours) {
    add(text, one.name + "/" + one.material + "/" + one.behavior + "/" + three_digits(one.mass_kg) + "/" +
                  three_digits(one.distance_m));
  }
  return text_hash(text);
}

void add_to(v1::AnalysisRecord& record, const RawAnswer& answer) {
  record.set_model(shown_text(answer.model, 80));
  record.set_prompt_version(shown_text(answer.prompt_version, 80));
  record.set_prompt_tokens(record.prompt_tokens() + answer.prompt_tokens);
  record.set_completion_tokens(record.completion_tokens() + answer.completion_tokens);
  record.set_cost_usd(record.cost_usd() + answer.cost_usd);
  record.set_wall_s(record.wall_s() + answer.wall_s);
}

// Steps 1 to 5 of the gate (gate/gate.h). The error is sent to the model as a repair turn.
Result<Answer> read_and_examine(const std::string& json, const AnalysisTarget& target,
                                const MessageTemplates& words) {
  auto answer = read_answer(json, words);
  if (!answer) return answer.error();
  return validate_answer(std::move(*answer), *target.facts, target.offline, words);
}

// Lifts the boxes of an answer about one view to votes of the kernels.
void lift_boxes(const TargetView& look, const ObjectFacts& facts, Answer& answer) {
  const bool boxed = std::any_of(answer.parts.begin(), answer.parts.end(),
                                 [](const AnswerPart& part) { return !part.boxes.empty(); });
  if (!boxed || !facts.kernels || look.sights.empty() || answer.parts.size() < 2) return;
  std::vector<BoxedPart> parts;
  for (const AnswerPart& part : answer.parts) {
    parts.push_back({part.boxes, !part.inside.empty()});
  }
  auto votes = picture_votes(look.sights, parts, facts.kernels->positions_m.size());
  for (size_t i = 0; i < votes.size(); ++i) answer.parts[i].votes = std::move(votes[i]);
}

}  // namespace

void ask_model(const AnalysisTarget& target, const std::vector<SceneObjectFacts>& neighbours,
               ModelEndpoint& endpoint, const EndpointState& state, const TargetViews& views,
               const AnalysisOptions& options, const std::function<void(AnalysisStage)>& staged,
               std::stop_token stop, AnalysisUpdate& update) {
  update.parameters = update.judgement.parameters = target.offline;
  update.record.Clear();
  const auto give_up = [&](std::string message) {
    if (update.judgement.message.empty()) update.judgement.message = std::move(message);
  };
  auto looks = views(target.object_id, options.views, stop);
  if (!looks) return give_up("views: " + looks.error().message);
  update.record.set_endpoint(state.name);
  std::vector<Answer> answers;
  std::string question_hashes, answer_hashes;
  bool all_cached = !looks->empty();
  for (const TargetView& look : *looks) {
    if (stop.stop_requested()) break;
    AnalysisQuestion question;
    question.slots = fact_slots(*target.facts, target.offline, neighbours, endpoint.words());
    question.slots.insert(look.slots.begin(), look.slots.end());
    question.images = look.images;
    const std::string key = question_hash(question, target, neighbours, state, options.prompt_version);
    question_hashes += key;

    const auto take = [&](const RawAnswer& raw, std::string repair, AnalysisQuestion asked) -> bool {
      AnalysisTurn turn;
      turn.question = std::move(asked);
      turn.repair = std::move(repair);
      turn.answer = raw;
      auto answer = read_and_examine(raw.json, target, endpoint.words());
      if (!answer) turn.error = answer.error().message;
      if (answer && raw.blind) {
        answer->blind = true;
        answer->changes.push_back("pictures: not accepted by the model; the question was sent without them");
      }
      update.turns.push_back(std::move(turn));
      if (!answer) return false;
      if (!answer->blind) lift_boxes(look, *target.facts, *answer);
      answers.push_back(std::move(*answer));
      answer_hashes += text_hash(raw.json);
      return true;
    };

    // Caching requires a known model name.
    AnswerCache* const cache = state.model.empty() ? nullptr : options.cache;
    if (cache) {
      if (const auto failed = cache->failure(key)) {
        give_up(*failed);
        continue;
      }
      if (const auto kept = cache->answer(key)) {
        if (take(*kept, "", question)) {
          update.record.set_model(shown_text(kept->model, 80));
          update.record.set_prompt_version(shown_text(kept->prompt_version, 80));
          update.record.set_views(update.record.views() + 1);
          continue;
        }
        update.turns.pop_back();  // the gate has changed since
      }
    }
    all_cached = false;
    staged(AnalysisStage::Asked);
    const auto exchange = endpoint.start(ToolBox(*target.facts, neighbours, endpoint.words()));
    auto raw = exchange->ask(question, stop);
    if (!raw) {
      update.cancelled = stop.stop_requested();
      give_up(raw.error().message);
      continue;
    }
    add_to(update.record, *raw);
    if (!raw->blind) update.record.set_views(update.record.views() + 1);
    bool taken = take(*raw, "", question);
    if (!taken && !stop.stop_requested()) {
      staged(AnalysisStage::Repaired);
      const std::string wrong = update.turns.back().error;
      // Tokens and time of a repair include the whole conversation; it is counted once.
      v1::AnalysisRecord before = update.record;
      auto again = exchange->repair(wrong, stop);
      if (again) {
        before.set_prompt_tokens(before.prompt_tokens() - raw->prompt_tokens);
        before.set_completion_tokens(before.completion_tokens() - raw->completion_tokens);
        before.set_cost_usd(before.cost_usd() - raw->cost_usd);
        before.set_wall_s(before.wall_s() - raw->wall_s);
        update.record = before;
        add_to(update.record, *again);
        raw = std::move(again);
        taken = take(*raw, wrong, {});
      }
    }
    if (taken) {
      // Blind answers are not cached: the server may accept pictures next time.
      if (cache && !raw->blind) cache->keep(key, *raw);
    } else {
      const std::string why = "faulty answer: " + update.turns.back().error;
      if (cache && !raw->blind && !stop.stop_requested()) cache->keep_failure(key, why);
      give_up(why);
    }
  }
  update.cancelled = update.cancelled || (stop.stop_requested() && answers.empty());
  if (answers.empty()) return;
  update.cached = all_cached;
  update.judgement = weigh_answer(vote(answers), *target.facts, target.offline);
  update.parameters = update.judgement.parameters;
  update.record.set_question_hash(text_hash(question_hashes));
  update.record.set_answer_hash(text_hash(answer_hashes));
  for (const std::string& change : update.judgement.changes) update.record.add_gate(change);
  for (const std::string& remark : update.judgement.remarks) update.record.add_gate(remark);
  if (update.judgement.verdict == Verdict::NeedsReview) update.record.set_review(update.judgement.message);
}

}  // namespace livegs
