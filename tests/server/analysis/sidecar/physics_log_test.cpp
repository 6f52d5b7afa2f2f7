// SPDX-License-Identifier: Apache-2.0
// Sidecars and logs that are deleted, cut, shared, or written when the program is killed.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/analysis/sidecar/physics_file_fixture.h"

namespace livegs {
namespace {

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

}  // namespace
}  // namespace livegs
