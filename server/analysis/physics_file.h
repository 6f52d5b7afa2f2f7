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

// What was worked out about an asset and what a person said of it, kept beside it as NAME.physics.json, with
// every revision in NAME.physics.log. A change is first appended to the log and synced, then the sidecar is
// replaced: a process that is killed in between leaves a log that is one record ahead, which every reader
// follows. Any thread, any process: who changes holds a lock on the log.

namespace livegs {

inline constexpr size_t kMaxPhysicsFileBytes = 1 << 20;

// mug.ply, mug.compressed.ply and mug/meta.json have mug.physics.json.
std::filesystem::path physics_file_path(const std::filesystem::path& asset);
// Of one of several objects that show the same asset: mug.physics.left.json, where letters, digits, - and _
// of the name stand as they are and every other byte as %20. Until it is there, mug.physics.json counts in
// its place.
std::filesystem::path physics_file_path(const std::filesystem::path& asset, std::string_view object);
// An object's name as files are named after it: no two names are spelt the same.
std::string object_file_name(std::string_view object);

// The sidecar as it counts, an edit by hand taken into `edits`; revision 0 when there is none of its own.
// Errors name the file with its folder, the field, its range and the remedy. Reads only.
Result<v1::PhysicsFile> read_physics_file(const std::filesystem::path& path);

// Each change is one revision and gives the file as it is now. Errors leave everything as it was. The first
// change of an object's own file takes what counted in its place along; what it took cannot be undone.
// `before` is called before every change of the disk.
Result<v1::PhysicsFile> apply_analysis(const std::filesystem::path& path,
                                       const v1::PhysicalParameters& physics,
                                       const v1::AnalysisRecord& record, const WriteStep& before = {});
// Keeps what needs review in the log; the sidecar stays as it is.
Result<void> log_proposal(const std::filesystem::path& path, const v1::PhysicalParameters& physics,
                          const v1::AnalysisRecord& record, const WriteStep& before = {});
// What was proposed last, if nothing was applied, edited or declined since; NotFound otherwise.
Result<v1::PhysicsFile> accept_proposal(const std::filesystem::path& path, const WriteStep& before = {});
// It waits no longer: a PROPOSAL without values in the log. The sidecar stays as it is; NotFound when nothing
// waits.
Result<v1::PhysicsFile> decline_proposal(const std::filesystem::path& path, const WriteStep& before = {});
// The proposal that accept_proposal() would take, if there is one; of a log that was read.
std::optional<v1::PhysicsFile> open_proposal(std::span<const v1::PhysicsLogRecord> log);
// Whether a person has taken back a model's answer, or declined what one proposed, and has not asked for
// another since.
bool answer_undone(std::span<const v1::PhysicsLogRecord> log);
// Fields given replace the same fields of earlier edits; the others stay. So does the name where it is empty.
Result<v1::PhysicsFile> edit_physics(const std::filesystem::path& path, const v1::Physics& edits,
                                     const WriteStep& before = {});
Result<v1::PhysicsFile> edit_physics(const std::filesystem::path& path, const v1::Physics& edits,
                                     const std::string& name, const WriteStep& before = {});
// NotFound when there is nothing (more) to undo or to redo.
Result<v1::PhysicsFile> undo_physics(const std::filesystem::path& path, const WriteStep& before = {});
Result<v1::PhysicsFile> redo_physics(const std::filesystem::path& path, const WriteStep& before = {});

// The records of the log, oldest first; a torn last line and lines that cannot be read are left out.
std::vector<v1::PhysicsLogRecord> read_physics_log(const std::filesystem::path& path);
// Those of them that count: none without a sidecar, and where one was deleted those since the next one began.
std::vector<v1::PhysicsLogRecord> read_decisions(const std::filesystem::path& path);

// `offline` with what the file holds in place of it: its analysis, but for what was a person's or a scene's
// in it, then its edits (source PERSON). Analysed values that depend on size are left out, and `note` says
// so, where the object stands in another size than it was analysed in.
Result<v1::PhysicalParameters> with_physics_file(const v1::PhysicalParameters& offline,
                                                 const v1::PhysicsFile& file, const ObjectFacts& facts,
                                                 std::string& note);

// Puts what `proposal` holds in place of what was analysed before: a person has accepted it.
void take_proposal(const v1::PhysicsFile& proposal, v1::PhysicsFile& file);

}  // namespace livegs
