// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

// What was decided about one object of a running scene: in its sidecar, or, for what has none and where the
// folder cannot be written, in memory until the server ends. Any thread.
class PhysicsOverrides {
 public:
  explicit PhysicsOverrides(std::filesystem::path file) : file_(std::move(file)) {}

  // Each gives what holds from now on. `note` says, once, that it is not kept on disk.
  Result<v1::PhysicsFile> apply(const v1::PhysicalParameters& physics, const v1::AnalysisRecord& record,
                                std::string& note);
  Result<v1::PhysicsFile> edit(const v1::Physics& edits, const std::string& name, std::string& note);
  Result<v1::PhysicsFile> step(bool redo, std::string& note);
  void propose(const v1::PhysicalParameters& physics, const v1::AnalysisRecord& record);
  Result<v1::PhysicsFile> accept(
      std::string& note);  // what was proposed last; NotFound when there is nothing
  Result<v1::PhysicsFile> decline(std::string& note);  // the same
  Result<v1::PhysicsFile> present() const;
  std::optional<v1::PhysicsFile> proposal() const;  // that accept() would take; its physics and analysis
  bool answer_undone() const;                       // physics_file.h

 private:
  const v1::PhysicsFile& push_revision(v1::PhysicsFile next);  // in memory
  template <class OnDisk, class InMemory>
  Result<v1::PhysicsFile> change(const OnDisk& on_disk, const InMemory& in_memory, std::string& note);

  mutable std::mutex mutex_;    // guards all below
  std::filesystem::path file_;  // empty: in memory
  std::vector<v1::PhysicsFile> revisions_ = std::vector<v1::PhysicsFile>(1);
  size_t current_ = 0;
  std::optional<v1::PhysicsFile> proposal_;  // in memory; its physics and analysis
};

}  // namespace livegs
