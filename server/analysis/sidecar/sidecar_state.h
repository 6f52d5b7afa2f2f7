// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

// Current state of sidecar and log, for the reader (physics_file.cpp) and the writer (sidecar_changes.cpp).

namespace livegs {

inline constexpr uint32_t kPhysicsLayout = 1;

// Sidecar and log together.
struct SidecarState {
  v1::PhysicsFile file;
  std::vector<v1::PhysicsLogRecord> log;  // records in effect
  uint64_t newest = 0;                    // highest revision in the whole log
  bool forgotten = false;                 // the log has obsolete records, and no record marks this yet
  bool manually_edited = false;
  bool there = false;       // the sidecar exists
  bool taken_over = false;  // the sidecar does not exist, and that of the asset is in effect
  uint64_t on_disk = 0;     // revision of the sidecar file
};

inline bool is_revision(const v1::PhysicsLogRecord& record) {
  return record.action() != v1::PhysicsLogRecord::PROPOSAL;
}

// Reads the effective sidecar and its log. Read-only; errors as for read_physics_file().
Result<SidecarState> read_sidecar_state(const std::filesystem::path& path);

}  // namespace livegs
