// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/physics_file.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "analysis/division/part_places.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/gate/answer.h"
#include "analysis/sidecar/manual_edits.h"
#include "analysis/sidecar/sidecar_state.h"
#include "analysis/text/json_text.h"
#include "core/content_hash.h"
#include "core/text/format_text.h"
#include "gaussian/asset_name.h"
#include "json/json_message.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using v1::PhysicsLogRecord;

constexpr size_t kMaxLogBytes = 64 << 20;
// Size ratio above which a stored analysis no longer applies to size-dependent values.
constexpr double kMaxSizeChange = 1.05;

// Sidecar used if that of one object does not exist: mug.physics.json for mug.physics.left.json; empty for
// others.
fs::path default_path(const fs::path& sidecar) {
  const std::string name = sidecar.stem().string();  // without .json
  const size_t dot = name.rfind('.');
  constexpr std::string_view kEnding = ".physics";
  if (dot == std::string::npos || name.substr(dot) == kEnding) return {};
  const std::string before = name.substr(0, dot);
  return before.ends_with(kEnding) ? sidecar.parent_path() / (before + ".json") : fs::path();
}

Error newer(double version) {
  return {ErrorCode::Unsupported,
          format_text("written by a newer LiveGS (layout %.0f, this one reads up to %u); update LiveGS, or "
                      "move the file and its .log away",
                      version, kPhysicsLayout)};
}

Result<v1::PhysicsFile> parse_sidecar(const std::string& text) {
  const Result<Json> json = parse_commented_json(text);
  if (!json) return json.error();
  if (!json->is_object()) return invalid_data("must contain one JSON object");
  // Checked before unknown contents of a newer layout.
  if (const auto version = number_member(*json, "version"); version && *version > kPhysicsLayout)
    return newer(*version);
  v1::PhysicsFile file;
  if (auto parsed = parse_json_message(text, file); !parsed) return parsed.error();
  if (file.version() > kPhysicsLayout) return newer(file.version());  // stored as text
  if (auto checked = check_scene_physics(file.edits()); !checked) {
    return invalid_argument("edits." + checked.error().message);
  }
  return file;
}

// Deleting a sidecar invalidates its log. The log is append-only, so the next sidecar begins with a
// TAKEN_OVER record: of the asset's sidecar, or empty.
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

}  // namespace

fs::path physics_log_path(const fs::path& sidecar) {
  fs::path path = sidecar;
  return path.replace_extension(".log");
}

Result<SidecarState> read_sidecar_state(const fs::path& path) {
  SidecarState kept;
  kept.log = read_physics_log(path);
  for (const PhysicsLogRecord& record : kept.log)
    kept.newest = std::max(kept.newest, record.file().revision());
  auto text = read_text_file(path, kMaxPhysicsFileBytes);
  if (!text && text.error().code != ErrorCode::NotFound) return text.error();
  const auto in_file = [&](const Error& error) {
    const char* remedy =
        error.code == ErrorCode::Unsupported ? "" : "; correct it, or delete the file to discard it";
    return Error{error.code, path.string() + ": " + error.message + remedy};
  };
  if (text) {
    auto file = parse_sidecar(*text);
    if (!file) return in_file(file.error());
    kept.file = std::move(*file);
    kept.there = true;
    kept.on_disk = kept.file.revision();
    auto edited = take_manual_edits(kept.file);
    if (!edited) return in_file(edited.error());
    kept.manually_edited = *edited;
  }
  if (!kept.there) {
    // A missing sidecar was deleted, whatever its log contains.
    kept.forgotten = !kept.log.empty();
    kept.log.clear();
    if (const fs::path other = default_path(path); !other.empty()) {
      auto instead = read_sidecar_state(other);
      if (!instead) return instead.error();
      kept.file = std::move(instead->file);
      kept.taken_over = kept.file.has_physics() || kept.file.has_edits() || !kept.file.name().empty();
      kept.file.set_revision(0);
    }
    return kept;
  }
  kept.log = since_begun(std::move(kept.log));
  // The process ended between log and sidecar: the last change is in the log only.
  const PhysicsLogRecord *newest = nullptr, *before = nullptr;
  for (const PhysicsLogRecord& record : kept.log) {
    if (is_revision(record)) before = std::exchange(newest, &record);
  }
  if (!newest) return kept;
  if (!kept.manually_edited) {
    if (newest->previous() == kept.on_disk && newest->file().revision() != kept.on_disk)
      kept.file = newest->file();
    return kept;
  }
  // The log may already hold a manual edit, followed by the change during which it was found.
  const auto holds_edit = [&](const PhysicsLogRecord& record) {
    return record.action() == PhysicsLogRecord::EDIT_BY_HAND && record.previous() == kept.on_disk &&
           same_content(record.file(), kept.file);
  };
  if (holds_edit(*newest) ||
      (before && holds_edit(*before) && newest->previous() == before->file().revision())) {
    kept.file = newest->file();
    kept.manually_edited = false;
  }
  return kept;
}

fs::path physics_file_path(const fs::path& asset) {
  fs::path path = asset;
  if (path.filename().empty()) path = path.parent_path();
  path = asset_stem(path);
  std::string name = path.filename().string();
  if (name.size() > 4 && name.ends_with(".csv")) name.erase(name.size() - 4);  // points
  return path.parent_path() / (name + ".physics.json");
}

std::string object_file_name(std::string_view object) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string name;
  for (const char c : object) {
    const bool plain =
        (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_';
    const auto byte = static_cast<unsigned char>(c);
    // "physics" alone would look like the sidecar of an asset.
    if (plain && !(name.empty() && object == "physics")) {
      name += c;
    } else {
      name += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  // File names are limited to 255 bytes, and a Chinese character takes nine here.
  constexpr size_t kMaxNameBytes = 150, kKeptNameBytes = 100, kHashDigits = 16;
  if (name.size() <= kMaxNameBytes) return name;
  size_t kept = kKeptNameBytes;
  while (name[kept - 1] == '%' || name[kept - 2] == '%') --kept;
  return name.substr(0, kept) + "-" + content_hash(std::as_bytes(std::span(object))).substr(0, kHashDigits);
}

fs::path physics_file_path(const fs::path& asset, std::string_view object) {
  const fs::path all = physics_file_path(asset);
  return all.parent_path() / (all.stem().string() + "." + object_file_name(object) + ".json");
}

std::vector<PhysicsLogRecord> read_physics_log(const fs::path& path) {
  std::vector<PhysicsLogRecord> records;
  const auto text = read_text_file(physics_log_path(path), kMaxLogBytes);
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
  auto kept = read_sidecar_state(path);
  if (!kept) return kept.error();
  return std::move(kept->file);
}

std::optional<v1::PhysicsFile> open_proposal(std::span<const PhysicsLogRecord> log) {
  for (auto record = log.rbegin(); record != log.rend(); ++record) {
    // A later edit supersedes the model's answer. A manual edit is logged together with the next change,
    // which may be the acceptance.
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
    if (!is_revision(record)) {
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

Result<v1::PhysicalParameters> with_physics_file(const v1::PhysicalParameters& offline,
                                                 const v1::PhysicsFile& file, const ObjectFacts& facts,
                                                 std::string& note) {
  v1::PhysicalParameters physics = offline;
  if (file.has_physics()) {
    physics = file.physics();
    // Values given by a user or a scene apply only while they are given.
    for (const PhysicsValue& value : physics_values()) {
      if (is_locked((physics.*value.get)())) *(physics.*value.mutable_value)() = (offline.*value.get)();
    }
    const double analysed_m = file.physics().longest_side_m().best(), now_m = facts.mesh.size_m.maxCoeff();
    if (analysed_m > 0 && now_m > 0 && std::abs(std::log(now_m / analysed_m)) > std::log(kMaxSizeChange)) {
      *physics.mutable_mass_kg() = offline.mass_kg();
      *physics.mutable_wall_thickness_m() = offline.wall_thickness_m();
      *physics.mutable_break_impulse_n_s() = offline.break_impulse_n_s();
      scale_parts(now_m / analysed_m, *physics.mutable_parts());
      char line[160];
      std::snprintf(line, sizeof line,
                    "was analysed at a length of %.3g m and is now %.3g m long, so its mass is estimated "
                    "again; analyze it to update",
                    analysed_m, now_m);
      note = line;
    }
  }
  return merge_scene_physics(physics, file.edits(), facts, v1::EstimatedValue::PERSON);
}

}  // namespace livegs
