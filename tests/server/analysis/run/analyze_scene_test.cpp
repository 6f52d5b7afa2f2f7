// SPDX-License-Identifier: Apache-2.0
#include "analysis/analyze_scene.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "analysis/run/explain_page.h"
#include "core/log.h"
#include "scratch_folder.h"
#include "server/analysis/gate/answer_fixtures.h"
#include "server/analysis/model/fake_endpoint.h"

namespace livegs {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

// Mugs of increasing size in a row.
std::vector<AnalysisTarget> mugs(size_t count) {
  std::vector<AnalysisTarget> targets;
  for (size_t i = 0; i < count; ++i) {
    ObjectFacts facts = mug_facts();
    facts.name = "mug " + std::string(1, static_cast<char>('a' + i));
    AnalysisTarget target;
    target.object_id = static_cast<uint32_t>(i + 10);
    target.offline = estimate_offline(facts);
    target.facts = std::make_shared<const ObjectFacts>(facts);
    target.position_m = {static_cast<double>(i), 0, 0};
    targets.push_back(std::move(target));
  }
  return targets;
}
Result<std::vector<TargetView>> look(uint32_t object_id, int count, std::stop_token) {
  std::vector<TargetView> views;
  for (int i = 0; i < count; ++i) {
    views.push_back(
        {{{"the scene", "image/png", "picture " + std::to_string(object_id) + "/" + std::to_string(i)}},
         "in front"});
  }
  return views;
}
// A mass that depends on the object and on its neighbours in the question.
Result<std::string> weigh(const AnalysisQuestion& question, const ToolBox& tools, int) {
  double mass_g = 300 + 5 * (question.slots.at("name").back() - 'a');
  for (const SceneObjectFacts& one : tools.scene()) {
    if (one.analysed) mass_g += one.mass_kg;
  }
  json answer = mug_answer();
  answer["mass_g"] = {{"low", mass_g * 0.9}, {"best", mass_g}, {"high", mass_g * 1.1}};
  return answer.dump();
}

struct Seen {
  std::vector<AnalysisUpdate> updates;
  AnalysisSummary summary;

  const AnalysisUpdate& last(size_t index) const {
    for (size_t i = updates.size(); i-- > 0;) {
      if (updates[i].index == index) return updates[i];
    }
    return updates.back();
  }
};
Seen run(std::span<const AnalysisTarget> targets, ModelEndpoint* endpoint, AnalysisOptions options = {},
         std::stop_token stop = {}, const TargetViews& views = look) {
  Seen result;
  result.summary = analyze_scene(
      targets, endpoint, views, options,
      [&](const AnalysisUpdate& update) { result.updates.push_back(update); }, stop);
  return result;
}

TEST(AnalyzeScene, OfflineFirstThenTheAcceptedAnswer) {
  const auto targets = mugs(3);
  FakeEndpoint endpoint(weigh);
  const Seen result = run(targets, &endpoint);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(result.updates[i].stage, AnalysisStage::Offline);
    EXPECT_EQ(result.updates[i].parameters.SerializeAsString(), targets[i].offline.SerializeAsString());
    const AnalysisUpdate& last = result.last(i);
    EXPECT_EQ(last.stage, AnalysisStage::Finished);
    EXPECT_EQ(last.judgement.verdict, Verdict::Accepted) << last.judgement.message;
    EXPECT_EQ(last.parameters.mass_kg().source(), v1::EstimatedValue::MODEL);
    EXPECT_EQ(last.record.model(), "fake-1");
    EXPECT_EQ(last.record.endpoint(), "fake");
    EXPECT_EQ(last.record.views(), 1u);
    EXPECT_EQ(last.record.question_hash().size(), 64u);
    EXPECT_GT(last.record.gate_size(), 0);
  }
  EXPECT_EQ(result.summary.accepted, 3u);
  EXPECT_EQ(result.summary.prompt_tokens, 3000);
}

TEST(AnalyzeScene, WithoutAnEndpointEstimatesAreKept) {
  const auto targets = mugs(2);
  const Seen result = run(targets, nullptr);
  EXPECT_EQ(result.updates.size(), 4u);
  EXPECT_EQ(result.last(1).stage, AnalysisStage::Finished);
  EXPECT_EQ(result.summary.failed, 2u);
  EXPECT_EQ(result.last(1).judgement.message, "no model endpoint is set");
}

TEST(AnalyzeScene, OneRepairThenTheOfflineEstimate) {
  const auto targets = mugs(1);
  const auto wrong = [](const AnalysisQuestion&, const ToolBox&, int) -> Result<std::string> {
    return std::string("no idea");
  };
  const auto mended = [](const AnalysisQuestion& q, const ToolBox& t, int turn) -> Result<std::string> {
    return turn == 0 ? Result<std::string>(std::string("{\"mass_g\": \"about a pound\"}"))
                     : weigh(q, t, turn);
  };
  FakeEndpoint mends(mended), never(wrong);
  const Seen good = run(targets, &mends);
  EXPECT_EQ(good.last(0).judgement.verdict, Verdict::Accepted);
  EXPECT_EQ(good.last(0).turns.size(), 2u);
  EXPECT_EQ(good.last(0).record.prompt_tokens(), 2000);  // of the whole conversation, once
  EXPECT_EQ(good.last(0).record.wall_s(), 4);
  ASSERT_EQ(mends.asked().size(), 2u);
  const Seen bad = run(targets, &never);
  EXPECT_EQ(bad.last(0).judgement.verdict, Verdict::Refused);
  EXPECT_EQ(bad.last(0).parameters.SerializeAsString(), targets[0].offline.SerializeAsString());
  EXPECT_EQ(never.asked().size(), 2u);
  EXPECT_EQ(bad.summary.refused, 1u);
}

// Questions and results do not depend on the timing of answers or the number in flight.
TEST(AnalyzeScene, ResultIsIndependentOfAnswerOrder) {
  const auto targets = mugs(9);
  std::vector<std::vector<std::string>> questions;
  std::vector<std::string> results;
  for (int order = 0; order < 4; ++order) {
    FakeEndpoint endpoint(weigh);
    endpoint.max_in_flight = order == 3 ? 1 : 4;
    endpoint.delay = [order](const std::string& name) {
      const int place = name.back() - 'a';
      return milliseconds(order == 0 ? 0 : order == 1 ? 30 - 3 * place : 7 * (place * 5 % 4));
    };
    const Seen result = run(targets, &endpoint);
    questions.push_back(endpoint.asked());
    std::string all;
    for (size_t i = 0; i < targets.size(); ++i) all += result.last(i).parameters.SerializeAsString();
    results.push_back(all);
  }
  for (int order = 1; order < 4; ++order) {
    EXPECT_EQ(questions[order], questions[0]);
    EXPECT_TRUE(results[order] == results[0]);
  }
  // Neighbours are included.
  EXPECT_NE(questions[0].back().find("mug a!"), std::string::npos) << questions[0].back();
}

TEST(AnalyzeScene, FailureKeepsEstimatesAndIsReportedOnce) {
  const auto targets = mugs(6);
  FakeEndpoint endpoint([](const AnalysisQuestion&, const ToolBox&, int) -> Result<std::string> {
    return Error{ErrorCode::Unavailable, "http://127.0.0.1:9: cannot be reached"};
  });
  testing::internal::CaptureStderr();
  const Seen result = run(targets, &endpoint);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(result.summary.failed, 6u);
  EXPECT_EQ(result.summary.failure, "http://127.0.0.1:9: cannot be reached");
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(result.last(i).parameters.SerializeAsString(), targets[i].offline.SerializeAsString());
    EXPECT_EQ(result.last(i).judgement.message, "http://127.0.0.1:9: cannot be reached");
  }
  EXPECT_EQ(log.find("cannot be reached"), log.rfind("cannot be reached")) << log;
  EXPECT_NE(log.find("cannot be reached"), std::string::npos);
}

TEST(AnalyzeScene, FailedViewsAffectOnlyTheirObject) {
  const auto targets = mugs(2);
  FakeEndpoint endpoint(weigh);
  const Seen result = run(targets, &endpoint, {}, {}, [](uint32_t id, int count, std::stop_token stop) {
    return id == 10 ? Result<std::vector<TargetView>>(not_found("nothing to draw")) : look(id, count, stop);
  });
  EXPECT_EQ(result.last(0).judgement.message, "views: nothing to draw");
  EXPECT_EQ(result.last(1).judgement.verdict, Verdict::Accepted);
}

// While the first query is slow, the pictures of the other objects are rendered.
TEST(AnalyzeScene, RendersViewsDuringQueries) {
  const auto targets = mugs(6);
  FakeEndpoint endpoint(weigh);
  endpoint.max_in_flight = 1;
  endpoint.delay = [](const std::string&) { return milliseconds(10000); };
  std::stop_source source;
  std::atomic<size_t> made{0};
  const Seen result =
      run(targets, &endpoint, {}, source.get_token(), [&](uint32_t id, int count, std::stop_token stop) {
        if (++made == targets.size()) source.request_stop();
        return look(id, count, stop);
      });
  EXPECT_EQ(made, targets.size());
  EXPECT_LE(endpoint.asked().size(), 1u);
}

TEST(AnalyzeScene, StopEndsAHang) {
  const auto targets = mugs(6);
  FakeEndpoint endpoint(weigh);
  endpoint.delay = [](const std::string&) { return milliseconds(600000); };
  std::stop_source source;
  std::jthread stopper([&] {
    while (endpoint.asked().size() < 4) std::this_thread::yield();
    source.request_stop();
  });
  const Seen result = run(targets, &endpoint, {}, source.get_token());
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(result.last(i).stage, AnalysisStage::Finished);
    EXPECT_TRUE(result.last(i).cancelled);
    EXPECT_EQ(result.last(i).parameters.SerializeAsString(), targets[i].offline.SerializeAsString());
  }
}

TEST(AnalyzeScene, SameQuestionIsSentOnce) {
  const auto targets = mugs(3);
  ScratchFolder folder;
  FakeEndpoint endpoint(weigh);
  std::string first;
  {
    AnswerCache cache(folder / "answers");
    AnalysisOptions options;
    options.cache = &cache;
    first = run(targets, &endpoint, options).last(2).parameters.SerializeAsString();
    run(targets, &endpoint, options);
  }
  EXPECT_EQ(endpoint.asked().size(), 3u);
  AnswerCache later(folder / "answers");  // another process
  AnalysisOptions options;
  options.cache = &later;
  const Seen again = run(targets, &endpoint, options);
  EXPECT_EQ(endpoint.asked().size(), 3u);
  EXPECT_TRUE(again.last(2).parameters.SerializeAsString() == first);
  EXPECT_TRUE(again.last(2).cached);
  EXPECT_EQ(again.last(2).record.model(), "fake-1");
  ASSERT_EQ(again.last(2).turns.size(), 1u);
  EXPECT_EQ(again.last(2).turns[0].answer.transcript, "said to mug c");  // for the explanation page
  EXPECT_EQ(again.last(2).turns[0].answer.warnings, std::vector<std::string>{"made up"});
  EXPECT_EQ(again.summary.prompt_tokens, 0);
  // Another picture changes the question.
  run(targets, &endpoint, options, {},
      [](uint32_t id, int count, std::stop_token stop) { return look(id + 1, count, stop); });
  EXPECT_EQ(endpoint.asked().size(), 6u);
}

// If no model is named, the actual one is identified first, so that cached answers of another model do not
// match.
TEST(AnalyzeScene, CacheIsSeparatePerModel) {
  const auto targets = mugs(2);
  AnswerCache cache;
  AnalysisOptions options;
  options.cache = &cache;
  for (const char* model : {"m1", "m2", "m1"}) {
    FakeEndpoint endpoint(weigh);
    endpoint.model = model;
    endpoint.names_its_model = false;
    const Seen result = run(targets, &endpoint, options);
    EXPECT_EQ(result.last(0).record.model(), model);
  }
  FakeEndpoint endpoint(weigh);
  endpoint.model = "m2";
  run(targets, &endpoint, options);
  EXPECT_TRUE(endpoint.asked().empty());
}

// An answer without pictures counts no views, says so, and is requested again once the server accepts
// pictures.
TEST(AnalyzeScene, BlindAnswerIsReportedAndNotCached) {
  const auto targets = mugs(1);
  AnswerCache cache;
  AnalysisOptions options;
  options.cache = &cache;
  FakeEndpoint endpoint(weigh);
  endpoint.blind = true;
  const Seen result = run(targets, &endpoint, options);
  const AnalysisUpdate& last = result.last(0);
  ASSERT_EQ(last.judgement.verdict, Verdict::Accepted) << last.judgement.message;
  EXPECT_EQ(last.record.views(), 0u);
  EXPECT_NE(last.parameters.fill_reason().find("without pictures"), std::string::npos)
      << last.parameters.fill_reason();
  EXPECT_EQ(last.parameters.fill_reason().find("saw"), std::string::npos);
  EXPECT_EQ(std::count(last.record.gate().begin(), last.record.gate().end(),
                       "pictures: not accepted by the model; the question was sent without them"),
            1);
  EXPECT_NE(explain_page(targets[0], last).find("none: the model takes no pictures"), std::string::npos);
  endpoint.blind = false;
  const Seen again = run(targets, &endpoint, options);
  EXPECT_EQ(endpoint.asked().size(), 2u);
  EXPECT_EQ(again.last(0).record.views(), 1u);
  EXPECT_NE(again.last(0).parameters.fill_reason().find("the model saw"), std::string::npos);
}

// A cached file that is too long to read would cause a second paid request.
TEST(AnalyzeScene, LongTranscriptIsDroppedFromTheCache) {
  ScratchFolder folder;
  RawAnswer answer;
  answer.json = "{}";
  answer.transcript = std::string(size_t{2} << 20, 'x');
  AnswerCache(folder / "answers").keep("key", answer);
  const auto kept = AnswerCache(folder / "answers").answer("key");
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->json, "{}");
  EXPECT_EQ(kept->transcript, "");
}

// Objects that are not queried are still described: values of the scene's author, a user or a model as known,
// others as estimates.
TEST(AnalyzeScene, QuestionsDescribeUnqueriedObjects) {
  const auto all = mugs(3);
  AnalysisOptions options;
  v1::PhysicalParameters given = all[0].offline;
  given.mutable_mass_kg()->set_best(1);
  given.mutable_mass_kg()->set_source(v1::EstimatedValue::SCENE);
  options.neighbours = {{all[0].facts, given, all[0].position_m},
                        {all[1].facts, all[1].offline, all[1].position_m}};
  FakeEndpoint endpoint(weigh);
  const Seen result = run(std::span(all).subspan(2), &endpoint, options);
  ASSERT_EQ(endpoint.asked().size(), 1u);
  const std::string line = endpoint.asked()[0];
  EXPECT_NE(line.find(" mug a!1.000000"), std::string::npos) << line;
  EXPECT_NE(line.find(" mug b?"), std::string::npos) << line;
  const auto& slot = result.last(0).turns.at(0).question.slots.at("neighbours");
  EXPECT_NE(slot.find("\"mug a\": 1000 g"), std::string::npos) << slot;
}

// A user's mass replaces the prior of class and size. An agreeing answer is near the prior, the question
// contains the mass, and dependent values follow from it.
TEST(AnalyzeScene, AnswersAreComparedWithUserValues) {
  auto targets = mugs(1);
  v1::Physics edits;
  const double given_kg = 12 * targets[0].offline.mass_kg().best();
  edits.set_mass_kg(given_kg);
  const auto heavy = [&](const AnalysisQuestion&, const ToolBox&, int) -> Result<std::string> {
    json answer = mug_answer();
    const double mass_g = 950 * given_kg;
    answer["mass_g"] = {{"low", mass_g * 0.9}, {"best", mass_g}, {"high", mass_g * 1.1}};
    return answer.dump();
  };
  FakeEndpoint endpoint(heavy);
  EXPECT_EQ(run(targets, &endpoint).last(0).judgement.verdict, Verdict::NeedsReview);
  const auto merged =
      merge_scene_physics(targets[0].offline, edits, *targets[0].facts, v1::EstimatedValue::PERSON);
  ASSERT_TRUE(merged);
  targets[0].offline = *merged;
  const Seen result = run(targets, &endpoint);
  const AnalysisUpdate& last = result.last(0);
  EXPECT_EQ(last.judgement.verdict, Verdict::Accepted) << last.judgement.message;
  EXPECT_EQ(last.parameters.mass_kg().best(), given_kg);
  EXPECT_EQ(last.parameters.mass_kg().source(), v1::EstimatedValue::PERSON);
  EXPECT_EQ(last.parameters.friction().source(), v1::EstimatedValue::MODEL);
  EXPECT_DOUBLE_EQ(last.parameters.break_impulse_n_s().best(), 3.1 * given_kg);
  EXPECT_NE(last.turns.at(0).question.slots.at("told").find("mass_kg "), std::string::npos);
}

TEST(AnalyzeScene, FailuresAreCachedForTenMinutes) {
  const auto targets = mugs(1);
  int64_t now = 0;
  AnswerCache cache({}, [&] { return now; });
  AnalysisOptions options;
  options.cache = &cache;
  FakeEndpoint endpoint([](const AnalysisQuestion&, const ToolBox&, int) -> Result<std::string> {
    return std::string("no idea");
  });
  run(targets, &endpoint, options);
  EXPECT_EQ(endpoint.asked().size(), 2u);
  now = AnswerCache::kFailureLifetime_ns - 1;
  const Seen soon = run(targets, &endpoint, options);
  EXPECT_EQ(endpoint.asked().size(), 2u);
  EXPECT_NE(soon.last(0).judgement.message.find("faulty answer"), std::string::npos);
  now = AnswerCache::kFailureLifetime_ns;
  run(targets, &endpoint, options);
  EXPECT_EQ(endpoint.asked().size(), 4u);
}

// A repeated program run does not pay for the same refusal again.
TEST(AnalyzeScene, FailuresPersistAcrossProcesses) {
  const ScratchFolder folder;
  int64_t now = AnswerCache::kFailureLifetime_ns;
  const auto clock = [&] { return now; };
  AnswerCache(folder / "answers", clock).keep_failure("key", "faulty answer: \"\xff");
  const auto kept = [&] { return AnswerCache(folder / "answers", clock).failure("key"); };
  ASSERT_TRUE(kept());
  EXPECT_TRUE(kept()->starts_with("faulty answer"));
  now += AnswerCache::kFailureLifetime_ns - 1;
  EXPECT_TRUE(kept());
  now -= AnswerCache::kFailureLifetime_ns;  // the clock was set back
  EXPECT_FALSE(kept());
  AnswerCache(folder / "answers", clock).keep_failure("key", "no");
  now += AnswerCache::kFailureLifetime_ns;
  EXPECT_FALSE(kept());
  EXPECT_TRUE(std::filesystem::is_empty(folder / "answers"));
  AnswerCache(folder / "answers", clock).keep_failure("key", "no");
  AnswerCache(folder / "answers", clock).keep("key", {});
  EXPECT_FALSE(kept());
  folder.write("answers/key.failed.json", "[1");
  EXPECT_FALSE(kept());
}

TEST(AnalyzeScene, CombinesThreeViewsByVote) {
  const auto targets = mugs(1);
  std::atomic<int> view = 0;
  FakeEndpoint endpoint([&](const AnalysisQuestion&, const ToolBox&, int) -> Result<std::string> {
    const double mass_g[] = {250, 330, 900};
    const double best = mass_g[view++];
    json answer = mug_answer();
    answer["mass_g"] = {{"low", best / 1.1}, {"best", best}, {"high", best * 1.1}};
    return answer.dump();
  });
  AnalysisOptions options;
  options.views = 3;
  const Seen result = run(targets, &endpoint, options);
  ASSERT_EQ(result.last(0).judgement.verdict, Verdict::Accepted) << result.last(0).judgement.message;
  EXPECT_EQ(result.last(0).record.views(), 3u);
  // The median of 330 g, moved towards the estimate according to the spread of the views.
  EXPECT_LT(std::abs(std::log(result.last(0).parameters.mass_kg().best() / 0.33)), 0.25);
}

// `analyze_bench` measures the times of one and of twenty objects.
TEST(AnalyzeScene, QueriesFourObjectsAtATime) {
  for (const size_t count : {size_t{1}, size_t{20}}) {
    const auto targets = mugs(count);
    FakeEndpoint endpoint(weigh);
    endpoint.delay = [](const std::string&) { return milliseconds(100); };
    const Seen result = run(targets, &endpoint);
    EXPECT_EQ(result.summary.accepted, count);
    EXPECT_EQ(endpoint.most_at_once(), static_cast<int>(std::min<size_t>(4, count)));
  }
}

TEST(ExplainPage, ContainsEverythingAndRunsNothing) {
  auto targets = mugs(1);
  ObjectFacts facts = *targets[0].facts;
  facts.name = "mug <script>alert(1)</script>";
  targets[0].facts = std::make_shared<const ObjectFacts>(facts);
  FakeEndpoint endpoint([](const AnalysisQuestion& q, const ToolBox& t, int turn) -> Result<std::string> {
    if (turn == 0) return std::string("<img src=x onerror=alert(1)> {\"mass_g\": 1}");
    json answer = json::parse(*weigh(q, t, turn));
    answer["evidence"] = "</pre><script>alert(2)</script>";
    return answer.dump();
  });
  const Seen result = run(targets, &endpoint);
  const std::string html = explain_page(targets[0], result.last(0));
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<img src=x"), std::string::npos);
  EXPECT_EQ(html.find("http://"), std::string::npos);
  EXPECT_EQ(html.find("https://"), std::string::npos);
  for (const char* part : {"data:image/png;base64,cGljdHVyZSAxMC8w", "&lt;script&gt;alert(2)",
                           "Sent to the model:", "accepted", "fused", "fake-1", "default-src 'none'"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
}

// Without a model's answer the page still shows the object, each view once.
TEST(ExplainPage, ShowsTheViewsWithOrWithoutAnAnswer) {
  const auto targets = mugs(1);
  const TargetView view{{{"the scene", "image/png", "scene bytes"}, {"alone", "image/png", "alone bytes"}},
                        "from the <front>",
                        {"where it is seen", "image/png", "mask bytes"}};
  const auto count = [](const std::string& text, const std::string& part) {
    size_t found = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
  };
  FakeEndpoint endpoint(weigh);
  for (FakeEndpoint* asked : {static_cast<FakeEndpoint*>(nullptr), &endpoint}) {
    const std::string html = explain_page(targets[0], run(targets, asked).last(0), std::span(&view, 1));
    EXPECT_EQ(count(html, "<img "), 3u);
    for (const char* bytes : {"c2NlbmUgYnl0ZXM=", "YWxvbmUgYnl0ZXM=", "bWFzayBieXRlcw=="}) {
      EXPECT_EQ(count(html, bytes), 1u) << bytes;
    }
    EXPECT_EQ(count(html, "Seen from the &lt;front&gt;."), 1u);
  }
}

}  // namespace
}  // namespace livegs
