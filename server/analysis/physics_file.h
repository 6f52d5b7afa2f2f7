// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/estimate.h"
#include "core/file.h"
#include "core/result.h"
#include "livegs/v1/physics.pb.h"

// Sidecar file of an asset: the analysis result and the user's edits, stored next to the asset as
// NAME.physics.json. Every revision is appended to NAME.physics.log.
//
// A change is first appended to the log and synced; then the sidecar is replaced. A process that is killed in
// between leaves a log that is one record ahead of the sidecar; every reader then uses the log.
// Any thread, any process: a writer holds a lock on the log.

namespace livegs {

inline constexpr size_t kMaxPhysicsFileBytes = 1 << 20;

// Sidecar path of an asset. mug.ply, mug.compressed.ply and mug/meta.json map to mug.physics.json.
std::filesystem::path physics_file_path(const std::filesystem::path& asset);
// Sidecar path of one of several objects that share an asset, for example mug.physics.left.json. Letters,
// digits, - and _ of the name are kept; every other byte is escaped as %20 is. Until the file exists,
// mug.physics.json applies.
std::filesystem::path physics_file_path(const std::filesystem::path& asset, std::string_view object);
// The log of changes and proposals next to a sidecar, NAME.physics.log.
std::filesystem::path physics_log_path(const std::filesystem::path& sidecar);
// Object name as used in file names; injective.
std::string object_file_name(std::string_view object);

// Reads the effective sidecar; a manual edit of the file is moved into `edits`. The revision is 0 if the
// object has no sidecar of its own. Errors name the file with its folder, the field, its range and the
// remedy.
// Read-only.
Result<v1::PhysicsFile> read_physics_file(const std::filesystem::path& path);

// Each function below that changes the file adds one revision and returns the new contents.
// Errors leave the file unchanged.
// The first change of an object's own file copies the previously effective sidecar; this copy cannot be
// undone.
// `before` is called before every write to the disk.
Result<v1::PhysicsFile> apply_analysis(const std::filesystem::path& path,
                                       const v1::PhysicalParameters& physics,
                                       const v1::AnalysisRecord& record, const WriteStep& before = {});
// Appends an answer that needs review to the log; the sidecar is unchanged.
Result<void> log_proposal(const std::filesystem::path& path, const v1::PhysicalParameters& physics,
                          const v1::AnalysisRecord& record, const WriteStep& before = {});
// Applies the last proposal. NotFound if something was applied, edited or declined since.
Result<v1::PhysicsFile> accept_proposal(const std::filesystem::path& path, const WriteStep& before = {});
// Declines the open proposal: appends a PROPOSAL without values to the log. The sidecar is unchanged.
// NotFound if there is no open proposal.
Result<v1::PhysicsFile> decline_proposal(const std::filesystem::path& path, const WriteStep& before = {});
// Returns the proposal that accept_proposal() would apply, if any. `log` as returned by read_physics_log().
std::optional<v1::PhysicsFile> open_proposal(std::span<const v1::PhysicsLogRecord> log);
// True if the user undid a model's answer or declined a proposal and has not requested another answer since.
bool answer_undone(std::span<const v1::PhysicsLogRecord> log);
// Replaces the given fields of earlier edits; other fields are unchanged. An empty name leaves the name
// unchanged.
Result<v1::PhysicsFile> edit_physics(const std::filesystem::path& path, const v1::Physics& edits,
                                     const WriteStep& before = {});
Result<v1::PhysicsFile> edit_physics(const std::filesystem::path& path, const v1::Physics& edits,
                                     const std::string& name, const WriteStep& before = {});
// Removes these fields of Physics from the edits, so that the analysis or the scene determines them again.
// Errors as for remove_edits() (sidecar/manual_edits.h).
Result<v1::PhysicsFile> restore_physics(const std::filesystem::path& path,
                                        std::span<const std::string> fields, const WriteStep& before = {});
// NotFound if there is nothing (more) to undo or redo.
Result<v1::PhysicsFile> undo_physics(const std::filesystem::path& path, const WriteStep& before = {});
Result<v1::PhysicsFile> redo_physics(const std::filesystem::path& path, const WriteStep& before = {});

// Reads the records of the log, oldest first. A truncated last line and unreadable lines are skipped.
std::vector<v1::PhysicsLogRecord> read_physics_log(const std::filesystem::path& path);
// Reads the log records in effect: none without a sidecar, and after a deletion only those of the new
// sidecar.
std::vector<v1::PhysicsLogRecord> read_decisions(const std::filesystem::path& path);

// Overlays the file on `offline`: its analysis without the values of a user or a scene, then its edits
// (source PERSON). If the object has another size than it was analysed in, size-dependent values of the
// analysis are skipped and `note` states it.
Result<v1::PhysicalParameters> with_physics_file(const v1::PhysicalParameters& offline,
                                                 const v1::PhysicsFile& file, const ObjectFacts& facts,
                                                 std::string& note);

// Replaces the analysis in `file` with `proposal`, after a user accepted it.
void take_proposal(const v1::PhysicsFile& proposal, v1::PhysicsFile& file);

}  // namespace livegs
