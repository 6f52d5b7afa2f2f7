// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/physics_file.h"
#include "scratch_folder.h"
#include "server/analysis/model/fake_endpoint.h"
#include "server/session/simulation/tick_log.h"
#include "session/live/analysis_controller.h"

// A running scene with a simulated model.

namespace livegs {

// A block and a sponge without physics, except what the scene states about the block, and a box with physics.
inline Scene open_scene(const ScratchFolder& folder, const std::string& block_physics = "{}",
                        const std::string& block_m = "0.1", uint32_t first_object_id = 1) {
  std::string points = "x,y,z\n";
  for (int i = 0; i < 64; ++i) {
    points += std::to_string(0.02 * (i % 4)) + "," + std::to_string(0.02 * (i / 4 % 4)) + "," +
              std::to_string(0.02 * (i / 16)) + "\n";
  }
  folder.write("sponge.csv", points);
  std::string text = R"({
    "substeps": 4, "environment": { "colliders": [ { "plane": {} } ] },
    "objects": [
      { "name": "wood block", "shape": { "box": { "size_m": [SIZE, 0.1, 0.1] } }, "pose": { "position_m": [0, 0.05, 0] },
        "physics": PHYSICS },
      { "name": "given", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } }, "pose": { "position_m": [1, 0.05, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1.0 } },
      { "name": "sponge", "points": "sponge.csv", "pose": { "position_m": [-1, 0.01, 0] } } ] })";
  text.replace(text.find("SIZE"), 4, block_m);
  text.replace(text.find("PHYSICS"), 7, block_physics);
  const auto path = folder.write("open.scene.json", text);
  SceneOptions options;
  options.rate_hz = 90;
  options.first_object_id = first_object_id;
  auto scene = Scene::load(path, options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

// 450 g for the block, 20 g for the sponge.
inline Result<std::string> weigh(const AnalysisQuestion& question, const ToolBox&, int) {
  const bool block = question.slots.at("name") == "wood block";
  const double grams = block ? 450 : 20;
  return nlohmann::json{
      {"name", block ? "block" : "sponge"},
      {"evidence", "grain"},
      {"fill", "solid"},
      {"parts", {{{"name", "all"}, {"material_id", block ? "softwood" : "kitchen sponge"}, {"share", 1}}}},
      {"behaviour", block ? "rigid" : "elastic"},
      {"mass_g", {{"low", grams * 0.9}, {"best", grams}, {"high", grams * 1.1}}},
      {"young_mpa", nullptr},
      {"structure_s", nullptr},
      {"plasticity", nullptr},
      {"fragile", false},
      {"friction", 0.4},
      {"restitution", 0.3},
      {"confidence", 0.9}}
      .dump();
}

// A block ten times heavier than plausible.
inline Result<std::string> weigh_too_much(const AnalysisQuestion& question, const ToolBox& tools, int turn) {
  auto answer = nlohmann::json::parse(*weigh(question, tools, turn));
  if (question.slots.at("name") == "wood block")
    answer["mass_g"] = {{"low", 4500}, {"best", 5000}, {"high", 5500}};
  return answer.dump();
}

class AnalysisControllerTest : public ::testing::Test {
 protected:
  // `say` null: no endpoint.
  void start(FakeEndpoint::Say say, std::chrono::milliseconds delay = std::chrono::milliseconds(0)) {
    skipped = log.ticks().size();
    Scene scene = open_scene(folder, block_physics);
    for (const SceneObject& object : scene.objects()) {
      ids[object.name] = object.id;
      offline_kg[object.name] = object.physics.mass_kg().best();
    }
    auto analysed = SceneAnalysis::of(scene);
    ASSERT_TRUE(analysed) << analysed.error().message;
    loop = std::make_unique<SimulationLoop>(std::move(scene), log, [this](const Scene& now) {
      for (const BodyState& body : now.world().bodies()) {
        if (body.object_id != ids.at("wood block")) continue;
        if (!body.asleep && block_asleep) ++awakenings;
        block_asleep = body.asleep;
      }
    });
    std::unique_ptr<FakeEndpoint> made;
    if (say) made = std::make_unique<FakeEndpoint>(std::move(say));
    if (made) made->delay = [delay](const std::string&) { return delay; };
    endpoint = made.get();
    analysis = std::make_unique<AnalysisController>(std::move(*analysed), std::move(made), *loop);
    loop->start();
  }
  // Waits for a tick in which the object changed to a state that `enough` accepts.
  bool changes_to(const std::string& name, const std::function<bool(const SceneObject&)>& enough) {
    return log.wait([&](const std::vector<TickResult>& ticks) {
      for (size_t i = skipped; i < ticks.size(); ++i) {
        for (const SceneObject& object : ticks[i].changed) {
          if (object.id == ids.at(name) && enough(object)) return true;
        }
      }
      return false;
    });
  }
  // Analyses one object as a client does; returns the last progress.
  v1::AnalysisProgress analyzed(const std::string& name) {
    std::mutex mutex;
    std::condition_variable changed;
    bool ended = false;
    v1::AnalysisProgress last;
    EXPECT_TRUE(analysis->analyze(
        {name},
        [&](const v1::AnalysisProgress& progress) {
          last = progress;
          return true;
        },
        [&] {
          std::lock_guard lock(mutex);
          ended = true;
          changed.notify_all();
        }));
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, kPatience, [&] { return ended; }));
    return last;
  }
  size_t changes_of(const std::string& name) {
    size_t count = 0;
    for (const TickResult& tick : log.ticks()) {
      for (const SceneObject& object : tick.changed) count += object.id == ids.at(name) ? 1 : 0;
    }
    return count;
  }

  ScratchFolder folder;
  TickLog log;
  std::string block_physics = "{}";
  std::atomic<bool> block_asleep = false;
  std::atomic<int> awakenings = 0;
  size_t skipped = 0;  // ticks of earlier loops
  std::map<std::string, uint32_t> ids;
  std::map<std::string, double> offline_kg;
  std::unique_ptr<SimulationLoop> loop;
  FakeEndpoint* endpoint = nullptr;
  std::unique_ptr<AnalysisController> analysis;
};

inline bool by_model(const SceneObject& object) {
  return object.physics.mass_kg().source() == v1::EstimatedValue::MODEL;
}

}  // namespace livegs
