// SPDX-License-Identifier: Apache-2.0
// Proposals of a model in the log of a sidecar.
#include <gtest/gtest.h>

#include "server/analysis/sidecar/physics_file_fixture.h"

namespace livegs {
namespace {

using v1::PhysicsLogRecord;

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

}  // namespace
}  // namespace livegs
