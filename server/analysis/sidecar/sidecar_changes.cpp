// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <google/protobuf/util/json_util.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "analysis/physics_file.h"
#include "analysis/sidecar/manual_edits.h"
#include "analysis/sidecar/sidecar_state.h"
#include "core/file.h"

// Changes of a sidecar, under a lock on its log. The log is appended to and synced before the sidecar is
// replaced.

namespace livegs {
namespace {

namespace fs = std::filesystem;
using v1::PhysicsLogRecord;

// Protobuf writes maps in arbitrary order; sorting makes files identical to the byte.
void sort_decided(nlohmann::ordered_json& json) {
  if (!json.is_object()) return;
  for (auto& [name, value] : json.items()) {
    if (name == "as_decided") {
      value = nlohmann::ordered_json(nlohmann::json(value));  // sorted by name
    } else {
      sort_decided(value);
    }
  }
}

Result<std::string> json_of(const google::protobuf::Message& message, bool pretty) {
  google::protobuf::util::JsonPrintOptions print;
  print.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(message, &text, print).ok()) {
    return Error{ErrorCode::Internal, "physics could not be written as JSON"};
  }
  auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (json.is_discarded()) return Error{ErrorCode::Internal, "physics could not be written as JSON"};
  sort_decided(json);
  return pretty ? json.dump(1) + "\n" : json.dump();
}

class LockedLog {
 public:
  static Result<LockedLog> open(const fs::path& sidecar, const WriteStep& before) {
    const fs::path path = physics_log_path(sidecar);
    if (before) before("open log");
    const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0) {
      const fs::path folder = sidecar.has_parent_path() ? sidecar.parent_path() : ".";
      return Error{ErrorCode::PermissionDenied,
                   sidecar.string() + ": cannot be written: " + std::strerror(errno) + "; make " +
                       folder.string() + " writable to save decisions"};
    }
    LockedLog log(fd, path);
    while (::flock(fd, LOCK_EX) != 0) {
      if (errno != EINTR) return log.error();
    }
    return log;
  }
  LockedLog(LockedLog&& other) noexcept : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)) {}
  LockedLog& operator=(LockedLog&&) = delete;
  ~LockedLog() {
    if (fd_ >= 0) ::close(fd_);
  }

  Result<void> append(const PhysicsLogRecord& record, const WriteStep& before) {
    auto line = json_of(record, false);
    if (!line) return line.error();
    *line += '\n';
    const auto step = [&](const char* name) {
      if (before) before(name);
    };
    const off_t end = end_of_lines();
    step("truncate log");
    if (end < 0 || ::ftruncate(fd_, end) != 0 || ::lseek(fd_, end, SEEK_SET) != end) return error();
    for (size_t done = 0; done < line->size();) {
      step("append");
      // Written in halves, so that a test can end the process within a line.
      const size_t part = std::max<size_t>(1, (line->size() - done + 1) / 2);
      const ssize_t wrote = ::write(fd_, line->data() + done, done == 0 ? part : line->size() - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) {
        const Error failed = error();
        (void)!::ftruncate(fd_, end);
        return failed;
      }
      done += static_cast<size_t>(wrote);
    }
    step("sync log");
    if (::fsync(fd_) != 0) return error();
    if (end == 0) {
      const fs::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
      const int names = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      if (names >= 0) {
        (void)::fsync(names);
        ::close(names);
      }
    }
    return {};
  }

 private:
  LockedLog(int fd, fs::path path) : fd_(fd), path_(std::move(path)) {}
  Error error() const { return file_error(path_, "cannot be written"); }
  // Offset after the last complete line.
  off_t end_of_lines() const {
    off_t end = ::lseek(fd_, 0, SEEK_END);
    char last = 0;
    while (end > 0 && ::pread(fd_, &last, 1, end - 1) == 1 && last != '\n') --end;
    return end;
  }

  int fd_;
  fs::path path_;
};

// Revisions available for undo and redo from the last record.
struct ChangeCourse {
  std::vector<uint64_t> back, forward;
};
ChangeCourse course_of(const std::vector<PhysicsLogRecord>& log) {
  ChangeCourse course;
  for (const PhysicsLogRecord& record : log) {
    switch (record.action()) {
      case PhysicsLogRecord::UNDO:
        course.forward.push_back(record.previous());
        if (!course.back.empty()) course.back.pop_back();
        break;
      case PhysicsLogRecord::REDO:
        if (!course.forward.empty()) course.forward.pop_back();
        course.back.push_back(record.previous());
        break;
      case PhysicsLogRecord::PROPOSAL:
        break;
      case PhysicsLogRecord::TAKEN_OVER:
        course = {};
        break;
      default:
        course.forward.clear();
        course.back.push_back(record.previous());
    }
  }
  return course;
}

std::optional<v1::PhysicsFile> content_of(const std::vector<PhysicsLogRecord>& log, uint64_t revision) {
  if (revision == 0) {
    v1::PhysicsFile empty;
    empty.set_version(kPhysicsLayout);
    return empty;
  }
  for (auto record = log.rbegin(); record != log.rend(); ++record) {
    if (is_revision(*record) && record->file().revision() == revision) return record->file();
  }
  return std::nullopt;
}

// Runs one change under the lock. `change` derives the next content from the current one and returns the
// action.
template <class Change>
Result<v1::PhysicsFile> change_file(const fs::path& path, const WriteStep& before, const Change& change) {
  auto log = LockedLog::open(path, before);
  if (!log) return log.error();
  auto kept = read_sidecar_state(path);
  if (!kept) return kept.error();
  uint64_t newest = std::max(kept->file.revision(), kept->newest);
  // Unlogged state becomes a revision of its own, available for undo: a manual edit, the asset's sidecar, a
  // deletion, or a sidecar without its log. An empty state stays revision 0.
  std::optional<PhysicsLogRecord> found;
  const bool unknown = kept->file.revision() > 0 && !content_of(kept->log, kept->file.revision());
  if (kept->manually_edited || kept->taken_over || kept->forgotten || unknown) {
    found.emplace();
    const bool begins = kept->taken_over || kept->forgotten;
    found->set_action(begins ? PhysicsLogRecord::TAKEN_OVER : PhysicsLogRecord::EDIT_BY_HAND);
    found->set_previous(kept->manually_edited ? kept->on_disk : 0);
    if (kept->manually_edited || kept->taken_over) kept->file.set_revision(++newest);
    kept->file.set_version(kPhysicsLayout);
    seal(kept->file);
    *found->mutable_file() = kept->file;
    kept->log.push_back(*found);
  }
  PhysicsLogRecord record;
  record.set_previous(kept->file.revision());
  auto next = change(*kept, record);
  if (!next) return next.error();
  if (found) {
    if (auto appended = log->append(*found, before); !appended) return appended.error();
  }
  if (!kept->there) {
    // State before the change. If the log is not ahead of a file, the sidecar was deleted.
    v1::PhysicsFile first = kept->file;
    first.set_version(kPhysicsLayout);
    auto text = json_of(first, true);
    if (!text) return text.error();
    if (auto written = write_file_atomically(path, std::string_view(*text), before); !written)
      return written.error();
  }
  if (record.action() != PhysicsLogRecord::UNDO && record.action() != PhysicsLogRecord::REDO) {
    next->set_revision(record.action() == PhysicsLogRecord::PROPOSAL ? 0 : newest + 1);
    next->set_version(kPhysicsLayout);
    seal(*next);
  }
  *record.mutable_file() = *next;
  if (auto appended = log->append(record, before); !appended) return appended.error();
  if (record.action() == PhysicsLogRecord::PROPOSAL) return kept->file;
  auto text = json_of(*next, true);
  if (!text) return text.error();
  if (auto written = write_file_atomically(path, std::string_view(*text), before); !written)
    return written.error();
  return next;
}

}  // namespace

Result<v1::PhysicsFile> apply_analysis(const fs::path& path, const v1::PhysicalParameters& physics,
                                       const v1::AnalysisRecord& analysis, const WriteStep& before) {
  return change_file(path, before,
                     [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::ANALYSIS);
                       v1::PhysicsFile next = kept.file;
                       *next.mutable_physics() = physics;
                       *next.mutable_analysis() = analysis;
                       return next;
                     });
}

Result<void> log_proposal(const fs::path& path, const v1::PhysicalParameters& physics,
                          const v1::AnalysisRecord& analysis, const WriteStep& before) {
  auto kept = change_file(
      path, before, [&](const SidecarState& present, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
        record.set_action(PhysicsLogRecord::PROPOSAL);
        v1::PhysicsFile next = present.file;
        *next.mutable_physics() = physics;
        *next.mutable_analysis() = analysis;
        return next;
      });
  return kept ? Result<void>() : Result<void>(kept.error());
}

void take_proposal(const v1::PhysicsFile& proposal, v1::PhysicsFile& file) {
  *file.mutable_physics() = proposal.physics();
  *file.mutable_analysis() = proposal.analysis();
  file.mutable_analysis()->clear_review();
  file.mutable_analysis()->add_gate("accepted by the user");
}

Result<v1::PhysicsFile> accept_proposal(const fs::path& path, const WriteStep& before) {
  return change_file(path, before,
                     [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::ANALYSIS);
                       const auto proposal = open_proposal(kept.log);
                       if (!proposal) {
                         return not_found(path.string() + ": no proposal; analyse it again");
                       }
                       v1::PhysicsFile next = kept.file;
                       take_proposal(*proposal, next);
                       return next;
                     });
}

Result<v1::PhysicsFile> decline_proposal(const fs::path& path, const WriteStep& before) {
  return change_file(path, before,
                     [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::PROPOSAL);
                       if (!open_proposal(kept.log))
                         return not_found(path.string() + ": no proposal to decline");
                       return v1::PhysicsFile();
                     });
}

Result<v1::PhysicsFile> edit_physics(const fs::path& path, const v1::Physics& edits,
                                     const WriteStep& before) {
  return edit_physics(path, edits, "", before);
}

Result<v1::PhysicsFile> edit_physics(const fs::path& path, const v1::Physics& edits, const std::string& name,
                                     const WriteStep& before) {
  if (auto checked = check_scene_physics(edits); !checked) return checked.error();
  return change_file(path, before,
                     [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::EDIT);
                       v1::PhysicsFile next = kept.file;
                       merge_edits(*next.mutable_edits(), edits);
                       if (!name.empty()) next.set_name(physics_name(name));
                       return next;
                     });
}

Result<v1::PhysicsFile> restore_physics(const fs::path& path, std::span<const std::string> fields,
                                        const WriteStep& before) {
  return change_file(path, before,
                     [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::EDIT);
                       v1::PhysicsFile next = kept.file;
                       if (auto removed = remove_edits(*next.mutable_edits(), fields); !removed)
                         return removed.error();
                       return next;
                     });
}

Result<v1::PhysicsFile> undo_physics(const fs::path& path, const WriteStep& before) {
  return change_file(
      path, before, [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
        record.set_action(PhysicsLogRecord::UNDO);
        const ChangeCourse course = course_of(kept.log);
        auto content = course.back.empty() ? std::nullopt : content_of(kept.log, course.back.back());
        if (!content) return not_found(path.string() + ": there is nothing to undo");
        return std::move(*content);
      });
}

Result<v1::PhysicsFile> redo_physics(const fs::path& path, const WriteStep& before) {
  return change_file(
      path, before, [&](const SidecarState& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
        record.set_action(PhysicsLogRecord::REDO);
        const ChangeCourse course = course_of(kept.log);
        auto content = course.forward.empty() ? std::nullopt : content_of(kept.log, course.forward.back());
        if (!content) return not_found(path.string() + ": there is nothing to redo");
        return std::move(*content);
      });
}

}  // namespace livegs
