// SPDX-License-Identifier: Apache-2.0
#include "analysis/physics_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "scratch_folder.h"
#include "server/analysis/gate/answer_fixtures.h"

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::PhysicsLogRecord;

v1::PhysicalParameters analysed(double mass_kg) {
  auto p = estimate_offline(mug_facts());
  p.mutable_mass_kg()->set_best(mass_kg);
  p.mutable_mass_kg()->set_low(0.8 * mass_kg);
  p.mutable_mass_kg()->set_high(1.2 * mass_kg);
  p.mutable_mass_kg()->set_source(EstimatedValue::MODEL);
  return p;
}
v1::Physics edit_of_mass(double mass_kg) {
  v1::Physics edits;
  edits.set_mass_kg(mass_kg);
  return edits;
}
v1::AnalysisRecord record_of(const char* model) {
  v1::AnalysisRecord record;
  record.set_model(model);
  record.set_prompt_version("1-abc");
  record.add_gate("mass_g: fused");
  return record;
}
nlohmann::json json_of(const std::filesystem::path& path) {
  return nlohmann::json::parse(*read_text_file(path));
}

class PhysicsFileTest : public ::testing::Test {
 protected:
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

TEST_F(PhysicsFileTest, ProposalIsLoggedAndChangesNothing) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  const auto before = *read_text_file(path);
  ASSERT_TRUE(log_proposal(path, analysed(30), record_of("seer-1")));
  EXPECT_EQ(*read_text_file(path), before);
  const auto log = read_physics_log(path);
  ASSERT_EQ(log.size(), 2u);
  EXPECT_EQ(log[1].action(), PhysicsLogRecord::PROPOSAL);
  EXPECT_EQ(log[1].file().physics().mass_kg().best(), 30);
  ASSERT_TRUE(undo_physics(path));  // of the analysis, not of the proposal
  EXPECT_EQ(read().revision(), 0u);
}

// State that a starting program needs from earlier user actions.
TEST_F(PhysicsFileTest, LogHoldsProposalsAndUndoneAnswers) {
  const auto undone = [&] { return answer_undone(read_physics_log(path)); };
  const auto waits = [&] { return open_proposal(read_physics_log(path)).has_value(); };
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.7)));
  ASSERT_TRUE(undo_physics(path));
  EXPECT_FALSE(undone());  // an edit, not an answer
  ASSERT_TRUE(log_proposal(path, analysed(30), record_of("seer-1")));
  EXPECT_TRUE(waits());
  EXPECT_FALSE(undone());
  ASSERT_TRUE(accept_proposal(path));
  EXPECT_FALSE(waits());
  ASSERT_TRUE(undo_physics(path));
  EXPECT_TRUE(undone());
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.8)));
  EXPECT_TRUE(undone());
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-2")));
  EXPECT_FALSE(undone());
  ASSERT_TRUE(undo_physics(path));
  EXPECT_TRUE(undone());
  ASSERT_TRUE(redo_physics(path));
  EXPECT_FALSE(undone());
  auto json = json_of(path);  // a manual edit, not an undo
  json.erase("analysis");
  json.erase("physics");
  ASSERT_TRUE(write_file_atomically(path, json.dump(1)));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.9)));
  EXPECT_FALSE(undone());
}

TEST_F(PhysicsFileTest, ProposalCanBeAccepted) {
  EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  v1::AnalysisRecord record = record_of("seer-2");
  record.set_review("ten times the estimate");
  v1::Physics edit;
  edit.set_friction(0.9);
  ASSERT_TRUE(edit_physics(path, edit));
  ASSERT_TRUE(log_proposal(path, analysed(3), record));
  ASSERT_TRUE(log_proposal(path, analysed(30), record));
  ASSERT_TRUE(accept_proposal(path));
  EXPECT_EQ(mass_kg(), 30);
  EXPECT_EQ(read().analysis().model(), "seer-2");
  EXPECT_EQ(read().analysis().review(), "");
  EXPECT_EQ(*read().analysis().gate().rbegin(), "accepted by the user");
  EXPECT_EQ(read().edits().friction(), 0.9);
  EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);  // only once
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(mass_kg(), 0.31);
  // A later applied answer replaces the proposal.
  ASSERT_TRUE(log_proposal(path, analysed(40), record));
  ASSERT_TRUE(apply_analysis(path, analysed(0.35), record_of("seer-3")));
  EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);
}

// By declining, which changes nothing, or by an edit. Either way no query follows until the user requests
// one.
TEST_F(PhysicsFileTest, ProposalCanBeDeclined) {
  const auto log = [&] { return read_decisions(path); };
  EXPECT_EQ(decline_proposal(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
  ASSERT_TRUE(log_proposal(path, analysed(30), record_of("seer-1")));
  const auto before = *read_text_file(path);
  EXPECT_FALSE(answer_undone(log()));
  ASSERT_TRUE(decline_proposal(path));
  EXPECT_EQ(*read_text_file(path), before);
  EXPECT_FALSE(open_proposal(log()));
  EXPECT_TRUE(answer_undone(log()));
  EXPECT_EQ(decline_proposal(path).error().code, ErrorCode::NotFound);  // only once
  EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(undo_physics(path));  // of the edit: declining is not a revision
  EXPECT_EQ(read().revision(), 0u);

  ASSERT_TRUE(log_proposal(path, analysed(40), record_of("seer-1")));  // after a new request by the user
  EXPECT_TRUE(open_proposal(log()));
  EXPECT_FALSE(answer_undone(log()));
  v1::Physics edit;
  edit.set_friction(0.9);
  ASSERT_TRUE(edit_physics(path, edit));
  EXPECT_FALSE(open_proposal(log()));
  EXPECT_TRUE(answer_undone(log()));
  EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  EXPECT_FALSE(answer_undone(log()));
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
        "or move the file and its .log away. Neither is modified";
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

TEST_F(PhysicsFileTest, DeletedSidecarStaysDeleted) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  std::filesystem::remove(path);
  EXPECT_EQ(read().revision(), 0u);
  ASSERT_TRUE(apply_analysis(path, analysed(0.4), record_of("seer-1")));
  EXPECT_EQ(read().revision(), 2u);  // revision numbers are unique
  EXPECT_EQ(mass_kg(), 0.4);
}

// The log remains, but without effect: no proposal, undo, redo or undone answer.
TEST_F(PhysicsFileTest, DeletingTheSidecarInvalidatesItsLog) {
  const auto forget = [&] {
    std::filesystem::remove(path);
    EXPECT_TRUE(read_decisions(path).empty());
    EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);
    EXPECT_EQ(decline_proposal(path).error().code, ErrorCode::NotFound);
    EXPECT_EQ(undo_physics(path).error().code, ErrorCode::NotFound);
    EXPECT_EQ(redo_physics(path).error().code, ErrorCode::NotFound);
    EXPECT_FALSE(std::filesystem::exists(path));
  };
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("seer-1")));
  ASSERT_TRUE(undo_physics(path));
  ASSERT_TRUE(log_proposal(path, analysed(30), record_of("seer-1")));
  forget();
  // The same after a new sidecar is written.
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
  EXPECT_FALSE(answer_undone(read_decisions(path)));
  EXPECT_EQ(accept_proposal(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(read().revision(), 0u);
  EXPECT_EQ(undo_physics(path).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(redo_physics(path));
  EXPECT_EQ(mass_kg(), 0.25);
  forget();
  ASSERT_TRUE(log_proposal(path, analysed(40), record_of("seer-1")));
  ASSERT_TRUE(accept_proposal(path));
  EXPECT_EQ(mass_kg(), 40);
  ASSERT_TRUE(undo_physics(path));
  EXPECT_EQ(undo_physics(path).error().code, ErrorCode::NotFound);
  EXPECT_GT(read_physics_log(path).size(), 8u);  // append-only
}

// Runs `change` in a child process that is killed before its `step`th write to the disk. Returns true if the
// child completed.
template <class Change>
bool survives(int step, const Change& change) {
  const pid_t child = ::fork();
  if (child == 0) {
    int count = 0;
    const auto kill_at = [&](const char*) {
      if (count++ == step) ::raise(SIGKILL);
    };
    ::_exit(change(kill_at) ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
  return WIFEXITED(status);
}

// After a kill between any two writes the state is the previous or the new one; once the log is synced it is
// the new one. Manual edits survive in any case, and later changes work as usual.
TEST_F(PhysicsFileTest, KillBetweenWritesLosesNothing) {
  const auto analysed_kg = [&] { return read().physics().mass_kg().best(); };
  const auto proposed_kg = [&] {
    double kg = 0;
    for (const v1::PhysicsLogRecord& record : read_physics_log(path)) {
      if (record.action() == v1::PhysicsLogRecord::PROPOSAL) kg = record.file().physics().mass_kg().best();
    }
    return kg;
  };
  const auto waiting_kg = [&] {
    const auto waits = open_proposal(read_decisions(path));
    return waits ? waits->physics().mass_kg().best() : 0;
  };
  const auto now_kg = [&] { return mass_kg(); };
  enum class From { Nothing, Edited, EditedByHand, Undone, Deleted, Proposed };
  struct Kill {
    const char* name;
    From from;
    std::function<bool(const WriteStep&)> change;
    std::function<double()> look;
    double before_kg, after_kg;
  };
  const Kill kills[] = {
      {"analysis of a new asset", From::Nothing,
       [&](auto& step) { return apply_analysis(path, analysed(0.31), record_of("s"), step).has_value(); },
       analysed_kg, 0, 0.31},
      {"analysis", From::Edited,
       [&](auto& step) { return apply_analysis(path, analysed(0.4), record_of("s"), step).has_value(); },
       analysed_kg, 0.31, 0.4},
      {"edit", From::Edited,
       [&](auto& step) { return edit_physics(path, edit_of_mass(0.2), step).has_value(); }, now_kg, 0.25,
       0.2},
      {"edit after an edit by hand", From::EditedByHand,
       [&](auto& step) { return edit_physics(path, edit_of_mass(0.2), step).has_value(); }, now_kg, 0.25,
       0.2},
      {"undo", From::Edited, [&](auto& step) { return undo_physics(path, step).has_value(); }, now_kg, 0.25,
       0.31},
      {"redo", From::Undone, [&](auto& step) { return redo_physics(path, step).has_value(); }, now_kg, 0.31,
       0.25},
      {"proposal", From::Edited,
       [&](auto& step) { return log_proposal(path, analysed(9), record_of("s"), step).has_value(); },
       proposed_kg, 0, 9},
      {"accepted proposal", From::Proposed,
       [&](auto& step) { return accept_proposal(path, step).has_value(); }, analysed_kg, 0.31, 9},
      {"declined proposal", From::Proposed,
       [&](auto& step) { return decline_proposal(path, step).has_value(); }, waiting_kg, 9, 0},
      {"analysis after the sidecar was deleted", From::Deleted,
       [&](auto& step) { return apply_analysis(path, analysed(0.4), record_of("s"), step).has_value(); },
       analysed_kg, 0, 0.4},
  };
  const auto contents = [&] {
    return std::pair(*read_text_file(path), *read_text_file(folder / "mug.physics.log"));
  };
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("s")));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
  const auto edited = contents();
  ASSERT_TRUE(log_proposal(path, analysed(9), record_of("s")));
  const auto proposed = contents();
  folder.write("mug.physics.json", edited.first);
  folder.write("mug.physics.log", edited.second);
  ASSERT_TRUE(undo_physics(path));
  const auto undone = contents();
  for (const char* name : {"mug.physics.json", "mug.physics.log"}) std::filesystem::remove(folder / name);
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("s")));
  const auto first = contents();  // its log is the one that could be ahead of a new sidecar
  const auto begin = [&](From from) {
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      std::filesystem::remove(entry.path());
    if (from == From::Nothing) return;
    const auto& [sidecar, log] = from == From::Undone     ? undone
                                 : from == From::Deleted  ? first
                                 : from == From::Proposed ? proposed
                                                          : edited;
    if (from != From::Deleted) folder.write("mug.physics.json", sidecar);
    folder.write("mug.physics.log", log);
    if (from == From::EditedByHand) edit_by_hand("/physics/friction/best", 0.77);
  };
  int killed = 0, decided_steps = 0;
  for (const Kill& kill : kills) {
    begin(kill.from);
    std::vector<std::string> names;
    ASSERT_TRUE(kill.change([&](const char* name) { names.emplace_back(name); })) << kill.name;
    // The record of the decision is synced last.
    const auto last_sync = std::find(names.rbegin(), names.rend(), "sync log");
    ASSERT_NE(last_sync, names.rend()) << kill.name;
    const auto synced = static_cast<int>(names.rend() - last_sync);  // writes up to that point
    for (int step = 0; step <= static_cast<int>(names.size()); ++step) {
      SCOPED_TRACE(std::string(kill.name) + ", step " + std::to_string(step));
      begin(kill.from);
      const bool done = survives(step, kill.change);
      ASSERT_EQ(done, step == static_cast<int>(names.size()));
      const double found_kg = kill.look(), layered_kg = mass_kg();
      if (step >= synced) {
        ASSERT_EQ(found_kg, kill.after_kg);
        decided_steps += done ? 0 : 1;
      } else {
        ASSERT_TRUE(found_kg == kill.before_kg || found_kg == kill.after_kg) << found_kg;
      }
      killed += done ? 0 : 1;
      if (kill.from == From::EditedByHand) {
        ASSERT_EQ(read().edits().friction(), 0.77);
      }
      // The recovered state accepts changes and undo.
      ASSERT_TRUE(edit_physics(path, edit_of_mass(0.123)));
      ASSERT_EQ(mass_kg(), 0.123);
      if (step % 3 == 0) {
        ASSERT_TRUE(undo_physics(path));
        ASSERT_EQ(mass_kg(), layered_kg);
      }
    }
  }
  EXPECT_GT(killed, 40);
  EXPECT_GT(decided_steps, 15);
}

// Objects that share an asset have separate sidecars; the asset's applies until one exists.
TEST_F(PhysicsFileTest, ObjectsOfAnAssetHaveSeparateSidecars) {
  EXPECT_EQ(physics_file_path("a/mug.ply", "left mug"), "a/mug.physics.left%20mug.json");
  // Eighty Chinese characters are 720 bytes in this encoding, and a file name is limited to 255; two long
  // names stay distinct.
  std::string bowls;
  for (int i = 0; i < 80; ++i) bowls += "\u7897";
  const std::string cut = physics_file_path("a/mug.ply", bowls).filename().string();
  EXPECT_LT(cut.size(), 160u);
  EXPECT_TRUE(cut.starts_with("mug.physics.%E7%A2%97%E7")) << cut;
  EXPECT_NE(cut, physics_file_path("a/mug.ply", bowls + "2").filename().string());
  EXPECT_EQ(physics_file_path("a/mug/meta.json", "../b"), "a/mug.physics.%2E%2E%2Fb.json");
  EXPECT_NE(physics_file_path("mug.ply", "physics"), physics_file_path("mug.physics.ply"));
  const auto left = physics_file_path(folder / "mug.ply", "left"),
             right = physics_file_path(folder / "mug.ply", "right");
  const auto mass_of = [&](const std::filesystem::path& own) {
    path = own;
    return mass_kg();
  };
  const auto all = path;
  ASSERT_TRUE(apply_analysis(all, analysed(0.31), record_of("seer-1")));
  ASSERT_TRUE(edit_physics(all, edit_of_mass(0.3)));
  EXPECT_EQ(mass_of(left), 0.3);
  EXPECT_EQ(read().revision(), 0u);  // without a sidecar of its own
  EXPECT_EQ(undo_physics(left).error().code, ErrorCode::NotFound);
  EXPECT_FALSE(std::filesystem::exists(left));

  ASSERT_TRUE(edit_physics(left, edit_of_mass(0.2)));
  ASSERT_TRUE(edit_physics(right, edit_of_mass(0.4)));
  EXPECT_EQ(mass_of(left), 0.2);
  EXPECT_EQ(read().analysis().model(), "seer-1");
  EXPECT_EQ(mass_of(right), 0.4);
  EXPECT_EQ(mass_of(all), 0.3);
  ASSERT_TRUE(undo_physics(right));
  EXPECT_EQ(mass_of(right), 0.3);
  EXPECT_EQ(undo_physics(right).error().code,
            ErrorCode::NotFound);  // the asset's revisions cannot be undone
  EXPECT_EQ(mass_of(left), 0.2);
  ASSERT_TRUE(edit_physics(all, edit_of_mass(0.9)));
  EXPECT_EQ(mass_of(right), 0.3);  // it has its own by now
  std::filesystem::remove(right);
  EXPECT_EQ(mass_of(right), 0.9);
}

TEST_F(PhysicsFileTest, KillDuringTakeOverLosesNothing) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("s")));
  path = physics_file_path(folder / "mug.ply", "left");
  const auto edit = [&](const WriteStep& step) {
    return edit_physics(path, edit_of_mass(0.2), step).has_value();
  };
  bool done = false;
  for (int step = 0; !done; ++step) {
    std::filesystem::remove(path);
    std::filesystem::remove(folder / "mug.physics.left.log");
    done = survives(step, edit);
    const double found_kg = mass_kg();
    ASSERT_TRUE(found_kg == 0.31 || found_kg == 0.2) << found_kg << " at step " << step;
    EXPECT_EQ(read().physics().mass_kg().best(), 0.31);
    ASSERT_TRUE(edit_physics(path, edit_of_mass(0.123)));
    ASSERT_TRUE(undo_physics(path));
    ASSERT_EQ(mass_kg(), found_kg);
    ASSERT_LT(step, 100);
  }
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

TEST_F(PhysicsFileTest, TruncatedLogIsReadUpToTheCut) {
  ASSERT_TRUE(apply_analysis(path, analysed(0.31), record_of("s")));
  ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
  const auto log = folder / "mug.physics.log";
  const std::string whole = *read_text_file(log);
  for (size_t length = 0; length < whole.size(); length += 211) {
    folder.write("mug.physics.log", whole.substr(0, length));
    ASSERT_EQ(mass_kg(), 0.25);  // in the sidecar
    ASSERT_TRUE(edit_physics(path, edit_of_mass(0.25)));
    ASSERT_EQ(mass_kg(), 0.25);
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
