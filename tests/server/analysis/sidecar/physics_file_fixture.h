// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "analysis/physics_file.h"
#include "scratch_folder.h"
#include "server/analysis/gate/answer_fixtures.h"

namespace livegs {

// The sidecar of a mug in a folder of its own.
class PhysicsFileTest : public ::testing::Test {
 protected:
  // As a model decides.
  static v1::PhysicalParameters analysed(double mass_kg) {
    auto p = estimate_offline(mug_facts());
    p.mutable_mass_kg()->set_best(mass_kg);
    p.mutable_mass_kg()->set_low(0.8 * mass_kg);
    p.mutable_mass_kg()->set_high(1.2 * mass_kg);
    p.mutable_mass_kg()->set_source(v1::EstimatedValue::MODEL);
    return p;
  }
  static v1::Physics edit_of_mass(double mass_kg) {
    v1::Physics edits;
    edits.set_mass_kg(mass_kg);
    return edits;
  }
  static v1::AnalysisRecord record_of(const char* model) {
    v1::AnalysisRecord record;
    record.set_model(model);
    record.set_prompt_version("1-abc");
    record.add_gate("mass_g: fused");
    return record;
  }
  static nlohmann::json json_of(const std::filesystem::path& path) {
    return nlohmann::json::parse(*read_text_file(path));
  }

  v1::PhysicsFile read() const {
    auto file = read_physics_file(path);
    EXPECT_TRUE(file) << file.error().message;
    return file ? *file : v1::PhysicsFile();
  }
  double mass_kg() const {
    std::string note;
    auto physics = with_physics_file(estimate_offline(mug_facts()), read(), mug_facts(), note);
    EXPECT_TRUE(physics) << physics.error().message;
    return physics->mass_kg().best();
  }
  // Rewrites the file with one member changed.
  void edit_by_hand(const char* pointer, const nlohmann::json& value) const {
    auto json = json_of(path);
    json[nlohmann::json::json_pointer(pointer)] = value;
    ASSERT_TRUE(write_file_atomically(path, json.dump(1)));
  }

  ScratchFolder folder;
  std::filesystem::path path = folder / "mug.physics.json";
};

}  // namespace livegs
