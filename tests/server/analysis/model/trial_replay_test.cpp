// SPDX-License-Identifier: Apache-2.0
// The whole answers of a trial with a real model, replayed by a server to the whole analysis: the client, the
// gate and the fusion. Skipped without the shared data.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "analysis/analyze_scene.h"
#include "core/file.h"
#include "server/analysis/gate/trial_objects.h"
#include "server/analysis/model/chat/model_endpoint_cases.h"

namespace livegs {
namespace {

Result<std::vector<TargetView>> trial_look(uint32_t, int, std::stop_token) {
  return std::vector<TargetView>{{{{"scene", "image/png", "\x89PNG"}}, "from the front"}};
}

// The reply of a model that thinks: no content, the answer at the end of its thoughts.
Reply thinks_aloud(const std::string& answer) {
  Reply reply = says("");
  Json body = Json::parse(reply.body);
  body["choices"][0]["message"]["reasoning"] = "The picture shows one object. " + answer;
  reply.body = body.dump();
  return reply;
}

AnalysisUpdate analyse_trial(const TrialAnswer& one, const Reply& reply) {
  const ObjectFacts facts = trial_facts(one);
  AnalysisTarget target;
  target.object_id = 1;
  target.facts = std::make_shared<const ObjectFacts>(facts);
  target.offline = estimate_offline(facts);
  TestHttpServer server(in_turn({reply}));
  EndpointSettings settings = test_settings(server.base_url());
  settings.tools = false;
  auto endpoint = open_model_endpoint(std::move(settings));
  AnalysisUpdate last;
  EXPECT_TRUE(endpoint) << endpoint.error().message;
  if (endpoint)
    analyze_scene(std::span(&target, 1), endpoint->get(), trial_look, {},
                  [&](const AnalysisUpdate& update) { last = update; });
  return last;
}

TEST(TrialReplay, WholeAnswersOfARealModelAreAccepted) {
  const std::filesystem::path folder =
      std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / ".." / "reference" / "analysis-trial";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "shared data is not here";
  double error = 0;
  for (const TrialAnswer& one : trial_answers()) {
    SCOPED_TRACE(one.folder);
    const auto answer = read_text_file(folder / one.folder / "answer.json");
    ASSERT_TRUE(answer) << answer.error().message;
    const AnalysisUpdate update = analyse_trial(one, says(*answer));
    EXPECT_EQ(update.judgement.verdict, Verdict::Accepted) << update.judgement.message;
    EXPECT_EQ(update.turns.size(), 1u);  // without a repair
    EXPECT_EQ(update.parameters.label(), one.name);
    const auto& mass = update.parameters.mass_kg();
    EXPECT_LE(mass.low(), 1e-3 * one.truth_g);
    EXPECT_GE(mass.high(), 1e-3 * one.truth_g);
    error += std::abs(1e3 * mass.best() / one.truth_g - 1) / static_cast<double>(trial_answers().size());
    EXPECT_EQ(analyse_trial(one, thinks_aloud(*answer)).parameters.SerializeAsString(),
              update.parameters.SerializeAsString());
  }
  std::printf("mean error %.1f %%\n", 100 * error);
  EXPECT_LE(error, 0.12);
}

}  // namespace
}  // namespace livegs
