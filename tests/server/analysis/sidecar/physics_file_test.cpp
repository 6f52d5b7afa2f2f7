// SPDX-License-Identifier: Apache-2.0
// Values of a sidecar: storage, edits, undo, and what a person or a program writes into the file.
#include <gtest/gtest.h>

#include "server/analysis/sidecar/physics_file_fixture.h"

namespace livegs {
namespace {

using v1::EstimatedValue;

TEST_F(PhysicsFileTest, IsStoredNextToItsAsset) {
  EXPECT_EQ(physics_file_path("a/mug.ply"), "a/mug.physics.json");
  EXPECT_EQ(physics_file_path("a/mug.compressed.ply"), "a/mug.physics.json");
  EXPECT_EQ(physics_file_path("mug.v2.spz"), "mug.v2.physics.json");
  EXPECT_EQ(physics_file_path("a/mug/meta.json"), "a/mug.physics.json");
  EXPECT_EQ(read().revision(), 0u);
  EXPECT_FALSE(std::filesystem::exists(path));  // reading writes nothing
}

TEST_F(PhysicsFileTest, StoresValuesWithTheirSource) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  const v1::PhysicsFile file = read();
  EXPECT_EQ(file.revision(), 1u);
  EXPECT_EQ(file.physics().mass_kg().source(), EstimatedValue::MODEL);
  EXPECT_EQ(file.analysis().model(), "seer-1");
  EXPECT_EQ(file.analysis().gate(0), "mass_g: fused");
  EXPECT_FALSE(file.has_edits());
  EXPECT_EQ(mass_kg(), 0.31);
}

TEST_F(PhysicsFileTest, EditsAreLockedAgainstLaterAnalyses) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
  ASSERT_TRUE(apply_analysis(path, analysed(0.4), record_of("seer-2")));
  EXPECT_EQ(mass_kg(), 0.25);
  EXPECT_EQ(read().physics().mass_kg().best(), 0.4);  // read, but not in effect
  std::string note;
  const auto physics = with_physics_file(estimate_offline(mug_facts()), read(), mug_facts(), note);
  EXPECT_EQ(physics->mass_kg().source(), EstimatedValue::PERSON);
}

TEST_F(PhysicsFileTest, EditedValueReturnsToTheEstimate) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  v1::Physics edits = edit_of_mass(0.25);
  edits.set_friction(0.9);
  ASSERT_TRUE(edit_physics(path, edits));
  const std::vector<std::string> mass{"mass_kg", "density_kg_m3"}, wrong{"mass"};
  ASSERT_TRUE(restore_physics(path, mass));
  EXPECT_EQ(mass_kg(), 0.31);
  EXPECT_EQ(read().edits().friction(), 0.9) << "other edits stay";
  EXPECT_EQ(restore_physics(path, mass).error().code, ErrorCode::NotFound);
  EXPECT_EQ(restore_physics(path, wrong).error().code, ErrorCode::InvalidArgument);
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(mass_kg(), 0.25);
  ASSERT_TRUE(redo_physics(path));
  EXPECT_EQ(mass_kg(), 0.31);
}

TEST_F(PhysicsFileTest, UndoAndRedoStepThroughRevisions) {
  EXPECT_EQ(undo_physics(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.2)));
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(mass_kg(), 0.25);
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(mass_kg(), 0.31);
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(mass_kg(), estimate_offline(mug_facts()).mass_kg().best());
  EXPECT_EQ(undo_physics(path).error().code, ErrorCode::NotFound);
  for (const double expected : {0.31, 0.25, 0.2}) {
    ASSERT_TRUE(redo_physics(path));
    EXPECT_EQ(mass_kg(), expected);
  }
  EXPECT_EQ(redo_physics(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(undo_physics(path));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.5)));  // an edit discards the redo revisions
  EXPECT_EQ(redo_physics(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(mass_kg(), 0.25);
  EXPECT_EQ(read_physics_log(path).size(), 12u);  // append-only
}

TEST_F(PhysicsFileTest, NameChangeIsARevision) {
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25), "tin mug"));
  EXPECT_EQ(read().name(), "tin mug");
  ASSERT_TRUE(edit_physics(path, {}, std::string(200, 'x') + "\n"));
  EXPECT_EQ(read().name(), std::string(80, 'x'));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.2)));
  EXPECT_EQ(read().name().size(), 80u);
  ASSERT_TRUE(undo_physics(path));
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(read().name(), "tin mug");
  EXPECT_EQ(mass_kg(), 0.25);
}

TEST_F(PhysicsFileTest, ManualEditsAreLocked) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  edit_by_hand("/physics/mass_kg/best", 0.28);
  edit_by_hand("/physics/friction/best", 0.9);
  edit_by_hand("/physics/fragile", false);
  edit_by_hand("/physics/label", "tin mug");
  EXPECT_EQ(mass_kg(), 0.28);
  EXPECT_EQ(read().name(), "tin mug");
  ASSERT_TRUE(apply_analysis(path, analysed(0.5), record_of("seer-2")));
  EXPECT_EQ(mass_kg(), 0.28);
  EXPECT_EQ(read().edits().friction(), 0.9);
  EXPECT_TRUE(read().edits().has_fragile());
  EXPECT_FALSE(read().edits().fragile());
  EXPECT_FALSE(read().edits().has_restitution());  // unchanged, hence not locked
  ASSERT_TRUE(undo_physics(path));                 // the second analysis
  EXPECT_EQ(mass_kg(), 0.28);
  ASSERT_TRUE(undo_physics(path));  // the manual edit
  EXPECT_EQ(mass_kg(), 0.31);
}

TEST_F(PhysicsFileTest, ManualFileIsLockedThroughout) {
  folder.write("mug.physics.json",
               R"({ "physics": { "mass_kg": { "best": 0.42 }, "behavior": "RIGID" } } // measured
  )");
  EXPECT_EQ(mass_kg(), 0.42);
  EXPECT_EQ(read().edits().behavior(), v1::Physics::RIGID);
  folder.write("mug.physics.json", R"({ "edits": { "density_kg_m3": 2300 } })");
  EXPECT_NE(mass_kg(), 0.42);
}

TEST_F(PhysicsFileTest, ErrorsNameFileFieldAndRange) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  const std::string good = *read_text_file(path);
  const auto message = [&] {
    auto file = read_physics_file(path);
    return file ? std::string("(no error)") : file.error().message;
  };
  const std::string remedy = "; correct it, or delete the file to discard it";
  edit_by_hand("/physics/mass_kg/best", -1);
  EXPECT_EQ(message(),
            path.string() + ": physics.mass_kg.best: is -1; it must be between 1e-06 and 1e+06" + remedy);
  folder.write("mug.physics.json", R"({ "edits": { "friction": 9 } })");
  EXPECT_EQ(message(), path.string() + ": edits.friction: is 9; it must be between 0 and 2" + remedy);
  folder.write("mug.physics.json", R"({ "edits": { "frictoin": 1 } })");
  EXPECT_NE(message().find("frictoin"), std::string::npos) << message();
  folder.write("mug.physics.json", "{ \"edits\": ");
  EXPECT_NE(message().find("mug.physics.json: is not JSON"), std::string::npos) << message();
  folder.write("mug.physics.json", "[]");
  EXPECT_NE(message().find("one JSON object" + remedy), std::string::npos) << message();
  folder.write("mug.physics.json", "{\"a\":" + std::string(400'000, '[') + std::string(400'000, ']') +
                                       "}");  // regression: traversing it crashed the program
  EXPECT_NE(message().find("is nested deeper than 64 levels" + remedy), std::string::npos) << message();
  for (size_t length = 0; length < good.size(); length += 41) {  // any bytes
    folder.write("mug.physics.json", good.substr(0, length));
    EXPECT_EQ(message().find('\n'), std::string::npos);
  }
  // A change on top of an unreadable file is refused and leaves it for correction.
  folder.write("mug.physics.json", "{ broken");
  EXPECT_FALSE(edit_physics(path, edit_of_mass(1)));
  EXPECT_EQ(*read_text_file(path), "{ broken");
}

// Also with unknown fields. The message does not suggest deletion, and neither the file nor its log changes.
TEST_F(PhysicsFileTest, FileOfANewerVersionIsNotModified) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  const std::string log = *read_text_file(folder.path() / "mug.physics.log");
  for (const char* newer : {R"({ "version": 7 })", R"({ "version": "7" })",
                            R"({ "version": 7, "viscosity": { "best": 3 }, "edits": { "friction": 9 } })"}) {
    folder.write("mug.physics.json", newer);
    const std::string expected =
        path.string() +
        ": written by a newer LiveGS (layout 7, this one reads up to 1); update LiveGS, "
        "or move the file and its .log away";
    const auto file = read_physics_file(path);
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().code, ErrorCode::Unsupported);
    EXPECT_EQ(file.error().message, expected);
    for (const auto& changed :
         {edit_physics(path, edit_of_mass(1)), apply_analysis(path, analysed(0.4), record_of("seer-2")),
          undo_physics(path), accept_proposal(path)}) {
      ASSERT_FALSE(changed);
      EXPECT_EQ(changed.error().message, expected);
    }
    EXPECT_FALSE(log_proposal(path, analysed(0.4), record_of("seer-2")));
    EXPECT_EQ(*read_text_file(path), newer);
    EXPECT_EQ(*read_text_file(folder.path() / "mug.physics.log"), log);
  }
}

TEST_F(PhysicsFileTest, ChangedSizeDiscardsTheMass) {
  auto physics = analysed(0.31);
  physics.mutable_longest_side_m()->set_best(0.095);
  ASSERT_TRUE(apply_analysis(path, physics, record_of("seer-1")));
  EXPECT_EQ(mass_kg(), 0.31);
  ObjectFacts large = mug_facts();
  large.mesh.size_m *= 2;
  std::string note;
  const auto there = with_physics_file(estimate_offline(large), read(), large, note);
  EXPECT_EQ(there->mass_kg().best(), estimate_offline(large).mass_kg().best());
  EXPECT_NE(note.find("analyze it to update"), std::string::npos);
}

TEST_F(PhysicsFileTest, ReadOnlyFolderIsAOneLineError) {
  folder.write("file", "");
  const auto failed = apply_analysis(folder / "file/mug.physics.json", analysed(0.31), record_of("seer-1"));
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("cannot be written"), std::string::npos) << failed.error().message;
  EXPECT_NE(failed.error().message.find("writable"), std::string::npos) << failed.error().message;
  EXPECT_EQ(failed.error().message.find('\n'), std::string::npos);
}

// Values given by a user or the scene at query time keep their source and are removed with it.
TEST_F(PhysicsFileTest, GivenValuesApplyOnlyWhileGiven) {
  const double offline_kg = estimate_offline(mug_facts()).mass_kg().best();
  for (const auto source : {EstimatedValue::PERSON, EstimatedValue::SCENE}) {
    auto answer = analysed(5);
    answer.mutable_mass_kg()->set_source(source);
    answer.mutable_friction()->set_best(0.33);
    answer.mutable_friction()->set_source(EstimatedValue::MODEL);
    ASSERT_TRUE(apply_analysis(path, answer, record_of("s")));
    EXPECT_EQ(mass_kg(), offline_kg);
    std::string note;
    const auto physics = with_physics_file(estimate_offline(mug_facts()), read(), mug_facts(), note);
    ASSERT_TRUE(physics);
    EXPECT_EQ(physics->friction().best(), 0.33);
  }
}

// A hammer of two parts, the head in a box.
v1::PhysicalParameters hammer_parameters() {
  ObjectFacts facts = mug_facts();
  facts.name = "hammer";
  v1::PhysicalParameters p = estimate_offline(facts);
  EXPECT_EQ(p.parts_size(), 2);
  auto& box = *p.mutable_parts(0)->add_boxes();
  for (const double one : {-0.1, 0.02, -0.1}) box.add_min_m(one);
  for (const double one : {0.1, 0.1, 0.1}) box.add_max_m(one);
  p.mutable_longest_side_m()->set_best(mug_facts().mesh.size_m.maxCoeff());
  return p;
}

TEST_F(PhysicsFileTest, PartsAreEditedByHandAndByAProgram) {
  const v1::PhysicalParameters decided = hammer_parameters();
  ASSERT_TRUE(apply_analysis(path, decided, {}));
  EXPECT_EQ(read().physics().parts(0).boxes(0).max_m(1), 0.1);
  EXPECT_EQ(read().edits().parts_size(), 0);  // unchanged numbers are no edit
  const auto effective = [&](const ObjectFacts& facts) {
    std::string note;
    auto physics = with_physics_file(estimate_offline(facts), read(), facts, note);
    EXPECT_TRUE(physics) << physics.error().message;
    return physics ? *physics : v1::PhysicalParameters();
  };
  EXPECT_EQ(effective(mug_facts()).parts_source(), EstimatedValue::OFFLINE);

  edit_by_hand("/physics/parts/0/boxes/0/max_m/1", 0.07);
  edit_by_hand("/physics/parts/1/material", "ABS");
  EXPECT_EQ(read().edits().parts_size(), 2);
  EXPECT_EQ(read().physics().parts(0).boxes(0).max_m(1), 0.1);  // as decided
  EXPECT_EQ(effective(mug_facts()).parts_source(), EstimatedValue::PERSON);
  EXPECT_EQ(effective(mug_facts()).parts(0).boxes(0).max_m(1), 0.07);
  EXPECT_EQ(effective(mug_facts()).parts(1).material(), "ABS");

  // A program replaces the list, and its change can be undone.
  v1::Physics edits;
  *edits.mutable_parts() = decided.parts();
  edits.mutable_parts(0)->set_material("brass");
  ASSERT_TRUE(edit_physics(path, edits));
  EXPECT_EQ(read().edits().parts_size(), 2);
  EXPECT_EQ(effective(mug_facts()).parts(0).material(), "brass");
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(effective(mug_facts()).parts(0).material(), decided.parts(0).material());
  EXPECT_EQ(effective(mug_facts()).parts(1).material(), "ABS");
  const std::vector<std::string> field = {"parts"};
  ASSERT_TRUE(restore_physics(path, field));
  EXPECT_EQ(effective(mug_facts()).parts_source(), EstimatedValue::OFFLINE);

  // An object of twice the size has boxes of twice the size.
  ObjectFacts large = mug_facts();
  large.mesh.size_m *= 2;
  EXPECT_NEAR(effective(large).parts(0).boxes(0).max_m(1), 0.2, 1e-12);
}

TEST_F(PhysicsFileTest, FaultyPartsNameTheirField) {
  ASSERT_TRUE(apply_analysis(path, hammer_parameters(), {}));
  const std::string before = *read_text_file(path);
  edit_by_hand("/physics/parts/1/mass_share", 0.9);
  auto file = read_physics_file(path);
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("physics.parts: the mass shares sum to"), std::string::npos)
      << file.error().message;
  ASSERT_TRUE(write_file_atomically(path, before));
  edit_by_hand("/physics/parts/1/material", "unobtainium");
  file = read_physics_file(path);
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("physics.parts[1].material"), std::string::npos)
      << file.error().message;
}

}  // namespace
}  // namespace livegs
