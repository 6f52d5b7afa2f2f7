// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

// Sidecar and log as they stand, for what reads them (physics_file.cpp) and what changes them
// (physics_changes.cpp).

namespace livegs {

inline constexpr uint32_t kPhysicsLayout = 1;

// Both together.
struct SidecarState {
  v1::PhysicsFile file;
  std::vector<v1::PhysicsLogRecord> log;  // what counts of it
  uint64_t newest = 0;                    // revision in all of it
  bool forgotten = false;                 // it has records that count no more, and nothing says so yet
  bool manually_edited = false;
  bool there = false;       // the sidecar
  bool taken_over = false;  // not there, and the asset's counts in its place
  uint64_t on_disk = 0;     // revision of the sidecar as it stands
};

inline bool is_revision(const v1::PhysicsLogRecord& record) {
  return record.action() != v1::PhysicsLogRecord::PROPOSAL;
}

// The sidecar as it counts, or what counts in its place, and its log. Reads only; errors as of
// read_physics_file().
Result<SidecarState> read_sidecar_state(const std::filesystem::path& path);

std::filesystem::path log_path(const std::filesystem::path& sidecar);

}  // namespace livegs
