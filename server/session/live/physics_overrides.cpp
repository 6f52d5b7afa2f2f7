// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/live/physics_overrides.h"

#include "analysis/physics_file.h"
#include "analysis/sidecar/manual_edits.h"

namespace livegs {

template <class OnDisk, class InMemory>
Result<v1::PhysicsFile> PhysicsOverrides::change(const OnDisk& on_disk, const InMemory& in_memory,
                                                 std::string& note) {
  std::lock_guard lock(mutex_);
  if (!file_.empty()) {
    auto changed = on_disk();
    if (changed) proposal_.reset();  // from an earlier failed write
    // The file cannot be written (PermissionDenied), or not now (Internal: no space).
    if (changed ||
        (changed.error().code != ErrorCode::PermissionDenied && changed.error().code != ErrorCode::Internal))
      return changed;
    note = "the values are kept until the server ends: " + changed.error().message;
    if (auto kept = read_physics_file(file_)) revisions_ = {std::move(*kept)};
    if (!proposal_) proposal_ = open_proposal(read_decisions(file_));
    current_ = 0;
    file_.clear();
  } else if (current_ == 0 && revisions_.size() == 1) {
    note =
        "the object has no file for its values: they are kept until the server ends; add them to the scene "
        "file";
  }
  return in_memory();
}

Result<v1::PhysicsFile> PhysicsOverrides::apply(const v1::PhysicalParameters& physics,
                                                const v1::AnalysisRecord& record, std::string& note) {
  return change([&] { return apply_analysis(file_, physics, record); },
                [&]() -> Result<v1::PhysicsFile> {
                  v1::PhysicsFile next = revisions_[current_];
                  *next.mutable_physics() = physics;
                  *next.mutable_analysis() = record;
                  proposal_.reset();
                  return push_revision(std::move(next));
                },
                note);
}

Result<v1::PhysicsFile> PhysicsOverrides::edit(const v1::Physics& edits, const std::string& name,
                                               std::string& note) {
  return change([&] { return edit_physics(file_, edits, name); },
                [&]() -> Result<v1::PhysicsFile> {
                  v1::PhysicsFile next = revisions_[current_];
                  merge_edits(*next.mutable_edits(), edits);
                  if (!name.empty()) next.set_name(physics_name(name));
                  proposal_.reset();
                  return push_revision(std::move(next));
                },
                note);
}

Result<v1::PhysicsFile> PhysicsOverrides::restore(std::span<const std::string> fields, std::string& note) {
  return change([&] { return restore_physics(file_, fields); },
                [&]() -> Result<v1::PhysicsFile> {
                  v1::PhysicsFile next = revisions_[current_];
                  if (auto removed = remove_edits(*next.mutable_edits(), fields); !removed)
                    return removed.error();
                  proposal_.reset();
                  return push_revision(std::move(next));
                },
                note);
}

Result<v1::PhysicsFile> PhysicsOverrides::step(bool redo, std::string& note) {
  return change([&] { return redo ? redo_physics(file_) : undo_physics(file_); },
                [&]() -> Result<v1::PhysicsFile> {
                  if (redo ? current_ + 1 >= revisions_.size() : current_ == 0) {
                    return not_found(std::string("physics: nothing to ") + (redo ? "redo" : "undo"));
                  }
                  current_ += redo ? 1 : -1;
                  return revisions_[current_];
                },
                note);
}

void PhysicsOverrides::propose(const v1::PhysicalParameters& physics, const v1::AnalysisRecord& record) {
  std::lock_guard lock(mutex_);
  proposal_.reset();
  if (!file_.empty() && log_proposal(file_, physics, record)) return;
  proposal_.emplace();
  *proposal_->mutable_physics() = physics;
  *proposal_->mutable_analysis() = record;
}

Result<v1::PhysicsFile> PhysicsOverrides::accept(std::string& note) {
  return change([&] { return accept_proposal(file_); },
                [&]() -> Result<v1::PhysicsFile> {
                  if (!proposal_) return not_found("proposal: does not exist; analyse the object again");
                  v1::PhysicsFile next = revisions_[current_];
                  take_proposal(*proposal_, next);
                  proposal_.reset();
                  return push_revision(std::move(next));
                },
                note);
}

Result<v1::PhysicsFile> PhysicsOverrides::decline(std::string& note) {
  return change([&] { return decline_proposal(file_); },
                [&]() -> Result<v1::PhysicsFile> {
                  if (!proposal_) return not_found("proposal: does not exist; there is nothing to decline");
                  proposal_.reset();
                  return revisions_[current_];
                },
                note);
}

std::optional<v1::PhysicsFile> PhysicsOverrides::proposal() const {
  std::lock_guard lock(mutex_);
  if (proposal_ || file_.empty()) return proposal_;
  return open_proposal(read_decisions(file_));
}

bool PhysicsOverrides::answer_undone() const {
  std::lock_guard lock(mutex_);
  return !file_.empty() && livegs::answer_undone(read_decisions(file_));
}

const v1::PhysicsFile& PhysicsOverrides::push_revision(v1::PhysicsFile next) {
  revisions_.resize(++current_);
  revisions_.push_back(std::move(next));
  return revisions_[current_];
}

Result<v1::PhysicsFile> PhysicsOverrides::present() const {
  std::lock_guard lock(mutex_);
  if (file_.empty()) return revisions_[current_];
  return read_physics_file(file_);
}

}  // namespace livegs
