// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

// The stored physics of one object of a running scene: in its sidecar, or in memory until the server ends if
// there is no sidecar or the folder is not writable. Any thread.
class PhysicsOverrides {
 public:
  explicit PhysicsOverrides(std::filesystem::path file) : file_(std::move(file)) {}

  // Each returns the resulting file. `note` is set once if the values are not stored on disk.
  Result<v1::PhysicsFile> apply(const v1::PhysicalParameters& physics, const v1::AnalysisRecord& record,
                                std::string& note);
  Result<v1::PhysicsFile> edit(const v1::Physics& edits, const std::string& name, std::string& note);
  Result<v1::PhysicsFile> restore(std::span<const std::string> fields, std::string& note);
  Result<v1::PhysicsFile> step(bool redo, std::string& note);
  void propose(const v1::PhysicalParameters& physics, const v1::AnalysisRecord& record);
  Result<v1::PhysicsFile> accept(std::string& note);   // the last proposal; NotFound if none
  Result<v1::PhysicsFile> decline(std::string& note);  // likewise
  Result<v1::PhysicsFile> present() const;
  std::optional<v1::PhysicsFile> proposal() const;  // the last proposal: its physics and analysis
  bool answer_undone() const;                       // physics_file.h

 private:
  const v1::PhysicsFile& push_revision(v1::PhysicsFile next);  // in memory
  template <class OnDisk, class InMemory>
  Result<v1::PhysicsFile> change(const OnDisk& on_disk, const InMemory& in_memory, std::string& note);

  mutable std::mutex mutex_;    // guards everything below
  std::filesystem::path file_;  // empty: in memory
  std::vector<v1::PhysicsFile> revisions_ = std::vector<v1::PhysicsFile>(1);
  size_t current_ = 0;
  std::optional<v1::PhysicsFile> proposal_;  // in memory; its physics and analysis
};

}  // namespace livegs
