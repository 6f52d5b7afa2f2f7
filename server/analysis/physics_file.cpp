// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/physics_file.h"

#include <fcntl.h>
#include <google/protobuf/util/json_util.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "analysis/answer.h"
#include "analysis/hand_edits.h"
#include "analysis/physics_values.h"
#include "core/content_hash.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using v1::PhysicsLogRecord;

constexpr uint32_t kLayout = 1;
constexpr size_t kMaxLogBytes = 64 << 20;
// Sizes that differ by more than this are not the same thing any more.
constexpr double kSameSize = 1.05;

fs::path log_path(const fs::path& sidecar) {
  fs::path path = sidecar;
  return path.replace_extension(".log");
}

// What counts where the file of one object is not there: mug.physics.json for mug.physics.left.json; empty for others.
fs::path default_path(const fs::path& sidecar) {
  const std::string name = sidecar.stem().string();  // without .json
  const size_t dot = name.rfind('.');
  constexpr std::string_view kEnding = ".physics";
  if (dot == std::string::npos || name.substr(dot) == kEnding) return {};
  const std::string before = name.substr(0, dot);
  return before.ends_with(kEnding) ? sidecar.parent_path() / (before + ".json") : fs::path();
}

// Protobuf writes a map in an order of its own each time; files are to be the same to the byte.
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

std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return text;
}

Result<v1::PhysicsFile> parse_file(const std::string& text) {
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(text, nullptr, true, true);
  } catch (const nlohmann::json::parse_error& error) {
    std::string what = error.what();
    if (const size_t colon = what.find("] "); colon != std::string::npos) what = what.substr(colon + 2);
    return invalid_data("is not JSON: " + one_line(what));
  }
  if (!json.is_object()) return invalid_data("must hold one JSON object");
  v1::PhysicsFile file;
  const auto status = google::protobuf::util::JsonStringToMessage(
      json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), &file);
  if (!status.ok()) {
    return invalid_data(one_line(std::string(status.message())) +
                        " (field names are those of PhysicsFile in proto/livegs/v1/physics.proto)");
  }
  if (file.version() > kLayout) {
    return Error{ErrorCode::Unsupported, "version: is " + std::to_string(file.version()) +
                                             "; this program knows up to " + std::to_string(kLayout)};
  }
  if (auto checked = check_scene_physics(file.edits()); !checked) {
    return invalid_argument("edits." + checked.error().message);
  }
  return file;
}

// Sidecar and log together.
struct Kept {
  v1::PhysicsFile file;
  std::vector<PhysicsLogRecord> log;  // what counts of it
  uint64_t newest = 0;                // revision in all of it
  bool forgotten = false;             // it has records that count no more, and nothing says so yet
  bool edited_by_hand = false;
  bool there = false;       // the sidecar
  bool taken_over = false;  // not there, and the asset's counts in its place
  uint64_t on_disk = 0;     // revision of the sidecar as it stands
};

bool changes(const PhysicsLogRecord& record) { return record.action() != PhysicsLogRecord::PROPOSAL; }

// Who deletes a sidecar forgets what its log says. The log only grows, so the next one begins with a TAKEN_OVER: of the
// asset's sidecar, or of nothing.
std::vector<PhysicsLogRecord> since_begun(std::vector<PhysicsLogRecord> log) {
  const auto begun = std::find_if(log.rbegin(), log.rend(), [](const PhysicsLogRecord& record) {
    return record.action() == PhysicsLogRecord::TAKEN_OVER;
  });
  if (begun != log.rend()) log.erase(log.begin(), std::prev(begun.base()));
  return log;
}

bool same_content(v1::PhysicsFile a, v1::PhysicsFile b) {
  for (v1::PhysicsFile* file : {&a, &b}) {
    file->clear_revision();
    file->clear_version();
    file->clear_as_decided();
  }
  return a.SerializeAsString() == b.SerializeAsString();
}

Result<Kept> read_kept(const fs::path& path) {
  Kept kept;
  kept.log = read_physics_log(path);
  for (const PhysicsLogRecord& record : kept.log) kept.newest = std::max(kept.newest, record.file().revision());
  auto text = read_text_file(path, kMaxPhysicsFileBytes);
  if (!text && text.error().code != ErrorCode::NotFound) return text.error();
  const auto in_file = [&](const Error& error) {
    return Error{error.code, path.string() + ": " + error.message + "; mend it, or delete the file to forget it"};
  };
  if (text) {
    auto file = parse_file(*text);
    if (!file) return in_file(file.error());
    kept.file = std::move(*file);
    kept.there = true;
    kept.on_disk = kept.file.revision();
    auto edited = take_hand_edits(kept.file);
    if (!edited) return in_file(edited.error());
    kept.edited_by_hand = *edited;
  }
  if (!kept.there) {
    // Gone, it was deleted, whatever its log says.
    kept.forgotten = !kept.log.empty();
    kept.log.clear();
    if (const fs::path other = default_path(path); !other.empty()) {
      auto instead = read_kept(other);
      if (!instead) return instead.error();
      kept.file = std::move(instead->file);
      kept.taken_over = kept.file.has_physics() || kept.file.has_edits() || !kept.file.name().empty();
      kept.file.set_revision(0);
    }
    return kept;
  }
  kept.log = since_begun(std::move(kept.log));
  // Ended between the log and the sidecar: the last change is in the log only.
  const PhysicsLogRecord *newest = nullptr, *before = nullptr;
  for (const PhysicsLogRecord& record : kept.log) {
    if (changes(record)) before = std::exchange(newest, &record);
  }
  if (!newest) return kept;
  if (!kept.edited_by_hand) {
    if (newest->previous() == kept.on_disk && newest->file().revision() != kept.on_disk) kept.file = newest->file();
    return kept;
  }
  // What was edited by hand may be in the log already, and the change that it was found by after it.
  const auto holds_edit = [&](const PhysicsLogRecord& record) {
    return record.action() == PhysicsLogRecord::EDIT_BY_HAND && record.previous() == kept.on_disk &&
           same_content(record.file(), kept.file);
  };
  if (holds_edit(*newest) ||
      (before && holds_edit(*before) && newest->previous() == before->file().revision())) {
    kept.file = newest->file();
    kept.edited_by_hand = false;
  }
  return kept;
}

class LockedLog {
 public:
  static Result<LockedLog> open(const fs::path& sidecar, const WriteStep& before) {
    const fs::path path = log_path(sidecar);
    if (before) before("open log");
    const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0) {
      const fs::path folder = sidecar.has_parent_path() ? sidecar.parent_path() : ".";
      return Error{ErrorCode::PermissionDenied,
                   sidecar.string() + ": cannot be written: " + std::strerror(errno) + "; make " +
                       folder.string() + " writable to keep what was decided"};
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
      // In halves, so that a test can end the process within a line.
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
  Error error() const {
    return {ErrorCode::PermissionDenied, path_.string() + ": cannot be written: " + std::strerror(errno)};
  }
  // After the last whole line.
  off_t end_of_lines() const {
    off_t end = ::lseek(fd_, 0, SEEK_END);
    char last = 0;
    while (end > 0 && ::pread(fd_, &last, 1, end - 1) == 1 && last != '\n') --end;
    return end;
  }

  int fd_;
  fs::path path_;
};

// The revisions that can be gone back to and forward to from the last record.
struct Course {
  std::vector<uint64_t> back, forward;
};
Course course_of(const std::vector<PhysicsLogRecord>& log) {
  Course course;
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
    empty.set_version(kLayout);
    return empty;
  }
  for (auto record = log.rbegin(); record != log.rend(); ++record) {
    if (changes(*record) && record->file().revision() == revision) return record->file();
  }
  return std::nullopt;
}

// One change under the lock. `change` makes the next content from what is kept, and says which action it was.
template <class Change>
Result<v1::PhysicsFile> change_file(const fs::path& path, const WriteStep& before, const Change& change) {
  auto log = LockedLog::open(path, before);
  if (!log) return log.error();
  auto kept = read_kept(path);
  if (!kept) return kept.error();
  uint64_t newest = std::max(kept->file.revision(), kept->newest);
  // What the log does not know: what a person wrote, what the asset's sidecar holds, that a sidecar was deleted, or one that
  // came without its log. It becomes a revision of its own, that can be gone back to; nothing stays revision 0.
  std::optional<PhysicsLogRecord> found;
  const bool unknown = kept->file.revision() > 0 && !content_of(kept->log, kept->file.revision());
  if (kept->edited_by_hand || kept->taken_over || kept->forgotten || unknown) {
    found.emplace();
    const bool begins = kept->taken_over || kept->forgotten;
    found->set_action(begins ? PhysicsLogRecord::TAKEN_OVER : PhysicsLogRecord::EDIT_BY_HAND);
    found->set_previous(kept->edited_by_hand ? kept->on_disk : 0);
    if (kept->edited_by_hand || kept->taken_over) kept->file.set_revision(++newest);
    kept->file.set_version(kLayout);
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
    // What counted until now before the change: where the log is ahead of nothing, the sidecar was deleted.
    v1::PhysicsFile first = kept->file;
    first.set_version(kLayout);
    auto text = json_of(first, true);
    if (!text) return text.error();
    if (auto written = write_file_atomically(path, std::string_view(*text), before); !written)
      return written.error();
  }
  if (record.action() != PhysicsLogRecord::UNDO && record.action() != PhysicsLogRecord::REDO) {
    next->set_revision(record.action() == PhysicsLogRecord::PROPOSAL ? 0 : newest + 1);
    next->set_version(kLayout);
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

fs::path physics_file_path(const fs::path& asset) {
  fs::path path = asset;
  if (path.filename() == "meta.json" || path.filename().empty()) path = path.parent_path();
  std::string name = path.filename().string();
  for (const std::string_view ending : {".compressed.ply", ".ply", ".spz", ".sog", ".splat", ".csv"}) {
    if (name.size() > ending.size() && name.ends_with(ending)) {
      name.erase(name.size() - ending.size());
      break;
    }
  }
  return path.parent_path() / (name + ".physics.json");
}

std::string object_file_name(std::string_view object) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string name;
  for (const char c : object) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_';
    const auto byte = static_cast<unsigned char>(c);
    // "physics" itself would read as an asset's own sidecar.
    if (plain && !(name.empty() && object == "physics")) {
      name += c;
    } else {
      name += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  // A file's name has 255 bytes at most, and a Chinese letter takes nine here.
  constexpr size_t kMost = 150, kKept = 100, kHashDigits = 16;
  if (name.size() <= kMost) return name;
  size_t kept = kKept;
  while (name[kept - 1] == '%' || name[kept - 2] == '%') --kept;
  return name.substr(0, kept) + "-" + content_hash(std::as_bytes(std::span(object))).substr(0, kHashDigits);
}

fs::path physics_file_path(const fs::path& asset, std::string_view object) {
  const fs::path all = physics_file_path(asset);
  return all.parent_path() / (all.stem().string() + "." + object_file_name(object) + ".json");
}

std::vector<PhysicsLogRecord> read_physics_log(const fs::path& path) {
  std::vector<PhysicsLogRecord> records;
  const auto text = read_text_file(log_path(path), kMaxLogBytes);
  if (!text) return records;
  for (size_t begin = 0, end; (end = text->find('\n', begin)) != std::string::npos; begin = end + 1) {
    PhysicsLogRecord record;
    google::protobuf::util::JsonParseOptions parse;
    parse.ignore_unknown_fields = true;
    const auto status =
        google::protobuf::util::JsonStringToMessage(text->substr(begin, end - begin), &record, parse);
    if (status.ok() && record.action() != PhysicsLogRecord::ACTION_UNKNOWN)
      records.push_back(std::move(record));
  }
  return records;
}

std::vector<PhysicsLogRecord> read_decisions(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  return since_begun(read_physics_log(path));
}

Result<v1::PhysicsFile> read_physics_file(const fs::path& path) {
  auto kept = read_kept(path);
  if (!kept) return kept.error();
  return std::move(kept->file);
}

Result<v1::PhysicsFile> apply_analysis(const fs::path& path, const v1::PhysicalParameters& physics,
                                       const v1::AnalysisRecord& analysis, const WriteStep& before) {
  return change_file(path, before,
                     [&](const Kept& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::ANALYSIS);
                       v1::PhysicsFile next = kept.file;
                       *next.mutable_physics() = physics;
                       *next.mutable_analysis() = analysis;
                       return next;
                     });
}

Result<void> log_proposal(const fs::path& path, const v1::PhysicalParameters& physics,
                          const v1::AnalysisRecord& analysis, const WriteStep& before) {
  auto kept = change_file(path, before,
                          [&](const Kept& present, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
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
  file.mutable_analysis()->add_gate("accepted by a person");
}

std::optional<v1::PhysicsFile> open_proposal(std::span<const PhysicsLogRecord> log) {
  for (auto record = log.rbegin(); record != log.rend(); ++record) {
    // An edit that comes after it is another answer than the model's. One by hand comes into the log with whatever
    // follows it, perhaps the acceptance.
    if (record->action() == PhysicsLogRecord::ANALYSIS || record->action() == PhysicsLogRecord::EDIT) break;
    if (record->action() != PhysicsLogRecord::PROPOSAL) continue;
    if (record->file().has_physics()) return record->file();
    break;  // declined
  }
  return std::nullopt;
}

bool answer_undone(std::span<const PhysicsLogRecord> log) {
  bool held = false, undone = false, waits = false;
  for (const PhysicsLogRecord& record : log) {
    if (!changes(record)) {
      const bool declined = !record.file().has_physics();
      if (waits || !declined) undone = declined;
      waits = !declined;
      continue;
    }
    if (record.action() == PhysicsLogRecord::EDIT && std::exchange(waits, false)) undone = true;
    if (record.action() == PhysicsLogRecord::ANALYSIS) waits = false;
    const bool holds = !record.file().analysis().model().empty();
    if (holds) undone = false;
    if (held && !holds) undone = record.action() == PhysicsLogRecord::UNDO;
    held = holds;
  }
  return undone;
}

std::string physics_name(std::string_view name) { return shown_text(name, 80); }

Result<v1::PhysicsFile> accept_proposal(const fs::path& path, const WriteStep& before) {
  return change_file(path, before,
                     [&](const Kept& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::ANALYSIS);
                       const auto proposal = open_proposal(kept.log);
                       if (!proposal) {
                         return not_found(path.string() + ": nothing is proposed; analyse it again");
                       }
                       v1::PhysicsFile next = kept.file;
                       take_proposal(*proposal, next);
                       return next;
                     });
}

Result<v1::PhysicsFile> decline_proposal(const fs::path& path, const WriteStep& before) {
  return change_file(path, before,
                     [&](const Kept& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::PROPOSAL);
                       if (!open_proposal(kept.log)) return not_found(path.string() + ": nothing is proposed");
                       return v1::PhysicsFile();
                     });
}

Result<v1::PhysicsFile> edit_physics(const fs::path& path, const v1::Physics& edits, const WriteStep& before) {
  return edit_physics(path, edits, "", before);
}

Result<v1::PhysicsFile> edit_physics(const fs::path& path, const v1::Physics& edits, const std::string& name,
                                     const WriteStep& before) {
  if (auto checked = check_scene_physics(edits); !checked) return checked.error();
  return change_file(path, before,
                     [&](const Kept& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
                       record.set_action(PhysicsLogRecord::EDIT);
                       v1::PhysicsFile next = kept.file;
                       merge_edits(*next.mutable_edits(), edits);
                       if (!name.empty()) next.set_name(physics_name(name));
                       return next;
                     });
}

Result<v1::PhysicsFile> undo_physics(const fs::path& path, const WriteStep& before) {
  return change_file(
      path, before, [&](const Kept& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
        record.set_action(PhysicsLogRecord::UNDO);
        const Course course = course_of(kept.log);
        auto content = course.back.empty() ? std::nullopt : content_of(kept.log, course.back.back());
        if (!content) return not_found(path.string() + ": there is nothing to undo");
        return std::move(*content);
      });
}

Result<v1::PhysicsFile> redo_physics(const fs::path& path, const WriteStep& before) {
  return change_file(
      path, before, [&](const Kept& kept, PhysicsLogRecord& record) -> Result<v1::PhysicsFile> {
        record.set_action(PhysicsLogRecord::REDO);
        const Course course = course_of(kept.log);
        auto content = course.forward.empty() ? std::nullopt : content_of(kept.log, course.forward.back());
        if (!content) return not_found(path.string() + ": there is nothing to redo");
        return std::move(*content);
      });
}

void merge_edits(v1::Physics& edits, const v1::Physics& later) {
  if (later.has_mass_kg()) edits.clear_density_kg_m3();
  if (later.has_density_kg_m3()) edits.clear_mass_kg();
  if (later.has_youngs_modulus_pa()) edits.clear_deformation_resistance();
  if (later.has_deformation_resistance()) edits.clear_youngs_modulus_pa();
  edits.MergeFrom(later);
}

Result<v1::PhysicalParameters> with_physics_file(const v1::PhysicalParameters& offline,
                                                 const v1::PhysicsFile& file, const ObjectFacts& facts,
                                                 std::string& note) {
  v1::PhysicalParameters physics = offline;
  if (file.has_physics()) {
    physics = file.physics();
    // What a person or a scene had told when it was asked is theirs, and holds only while they say it.
    for (const PhysicsValue& value : physics_values()) {
      const auto source = (physics.*value.get)().source();
      if (source == v1::EstimatedValue::PERSON || source == v1::EstimatedValue::SCENE) {
        *(physics.*value.mutable_value)() = (offline.*value.get)();
      }
    }
    const double analysed_m = file.physics().longest_side_m().best(), now_m = facts.mesh.size_m.maxCoeff();
    if (analysed_m > 0 && now_m > 0 && std::abs(std::log(now_m / analysed_m)) > std::log(kSameSize)) {
      *physics.mutable_mass_kg() = offline.mass_kg();
      *physics.mutable_wall_thickness_m() = offline.wall_thickness_m();
      *physics.mutable_break_impulse_n_s() = offline.break_impulse_n_s();
      char line[160];
      std::snprintf(
          line, sizeof line,
          "was analysed %.3g m long and stands %.3g m long: its mass is estimated anew; analyze it again",
          analysed_m, now_m);
      note = line;
    }
  }
  return merge_scene_physics(physics, file.edits(), facts, v1::EstimatedValue::PERSON);
}

}  // namespace livegs
