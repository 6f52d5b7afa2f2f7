// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/recording/recorded_files.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <utility>

#include "core/file.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "gaussian/asset_name.h"
#include "gaussian/gltf_files.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

using Visit = std::function<void(std::string& path)>;

void visit_given(std::string& path, const Visit& visit) {
  if (!path.empty()) visit(path);
}

// Visit every field that names a file.
void for_each_path(v1::Environment& environment, const Visit& visit) {
  visit_given(*environment.mutable_asset(), visit);
  visit_given(*environment.mutable_labels(), visit);
  for (v1::Collider& collider : *environment.mutable_colliders()) {
    if (collider.shape_case() == v1::Collider::kMesh) visit_given(*collider.mutable_mesh(), visit);
  }
}

void for_each_path(v1::Object& object, const Visit& visit) {
  if (object.form_case() == v1::Object::kAsset) visit_given(*object.mutable_asset(), visit);
  if (object.form_case() == v1::Object::kPoints) visit_given(*object.mutable_points(), visit);
}

// The files of an asset that is a folder, or of the folder of its index; of a streamed one with its chunks.
std::vector<std::string> files_in(const fs::path& folder, const std::string& name) {
  constexpr int kMaxDepth = 2;
  std::vector<std::string> files;
  std::error_code error;
  for (auto at = fs::recursive_directory_iterator(folder, error);
       !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    if (at.depth() >= kMaxDepth) at.disable_recursion_pending();
    const std::string file = at->path().filename().string();
    std::error_code ignored;
    const bool part = has_ending(file, ".webp") || has_ending(file, ".json") || has_ending(file, ".sog");
    if (part && at->is_regular_file(ignored))
      files.push_back((fs::path(name) / at->path().lexically_relative(folder)).string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The last component of a path; empty if it is not a valid file name.
std::string last_part(const fs::path& path) {
  const std::string name = path.filename().string();
  return name == "." || name == ".." || name.find('\0') != std::string::npos ? "" : name;
}

std::string without_trailing_slash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

// Where the files of a folder are unpacked. Folders keep their places relative to each other and their names,
// since an asset may consist of several files and folders. The first component separates paths from the root
// and from folders above.
fs::path own_folder(const fs::path& folder) {
  const fs::path normal = folder.lexically_normal();
  size_t above = 0;
  fs::path rest;
  for (const fs::path& part : normal.relative_path()) {
    if (part == "..")
      ++above;
    else if (part != "." && !part.empty())
      rest /= part;
  }
  const std::string origin = normal.is_absolute() ? "root" : "above_" + std::to_string(above);
  return rest.empty() ? fs::path(origin + "_itself") / "files" : fs::path(origin) / rest;
}

}  // namespace

void for_each_path(v1::Scene& scene, const std::function<void(std::string& path)>& visit) {
  if (scene.has_environment()) for_each_path(*scene.mutable_environment(), visit);
  for (v1::Object& object : *scene.mutable_objects()) for_each_path(object, visit);
  for (v1::Event& event : *scene.mutable_events()) {
    if (event.has_grab()) visit_given(*event.mutable_grab()->mutable_path(), visit);
    if (event.has_pull()) visit_given(*event.mutable_pull()->mutable_path(), visit);
  }
}

std::string stored_place(const std::string& given) {
  const fs::path normal = fs::path(without_trailing_slash(given)).lexically_normal();
  const bool elsewhere = normal.is_absolute() || (!normal.empty() && *normal.begin() == "..");
  if (!elsewhere) return normal.string();
  return (fs::path("elsewhere") / own_folder(normal.parent_path()) / normal.filename()).string();
}

std::vector<std::string> files_of(const v1::SceneSource& source) {
  std::vector<std::string> files;
  v1::Scene scene = source.file();
  const fs::path folder = source.folder();
  for_each_path(scene, [&](const std::string& given) {
    const std::string name = without_trailing_slash(given);
    std::error_code error;
    std::vector<std::string> found{name};
    if (fs::is_directory(folder / name, error))
      found = files_in(folder / name, name);
    else if (is_asset_index(name))
      found = files_in((folder / name).parent_path(), fs::path(name).parent_path().string());
    else if (has_ending(name, ".gltf")) {
      for (const std::string& buffer : gltf_buffer_files(folder / name))
        found.push_back((fs::path(name).parent_path() / buffer).string());
    }
    files.insert(files.end(), found.begin(), found.end());
  });
  // Labels stand next to the kernels that they label (parts/labelled_room.h).
  if (const std::string& labels = source.file().environment().labels(); !labels.empty())
    files.push_back(fs::path(labels).replace_extension(".ply").string());
  return files;
}

v1::SceneSource source_of(const v1::SceneChange& change, const std::string& folder) {
  v1::SceneSource source;
  source.set_folder(folder);
  if (change.has_environment()) *source.mutable_file()->mutable_environment() = change.environment();
  if (change.has_edit() && change.edit().has_after())
    *source.mutable_file()->add_objects() = change.edit().after();
  return source;
}

Result<void> embed_files(const v1::SceneSource& source, std::set<std::string>& held,
                         RecordingWriter& recording) {
  for (const std::string& name : files_of(source)) {
    if (!held.insert(name).second) continue;
    const auto bytes = read_file(fs::path(source.folder()) / name);
    if (!bytes) {
      log_warn("recording: a file is not embedded, and --verify will need it: %s",
               bytes.error().message.c_str());
      continue;
    }
    if (auto added = recording.add_file(name, *bytes); !added) return added;
  }
  return {};
}

UnpackedFiles::UnpackedFiles(UnpackedFiles&& other) noexcept
    : folder_(std::exchange(other.folder_, {})),
      paths_(std::move(other.paths_)),
      folders_(std::move(other.folders_)) {}

UnpackedFiles::~UnpackedFiles() {
  std::error_code error;
  if (!folder_.empty()) fs::remove_all(folder_, error);
}

Result<fs::path> UnpackedFiles::place(const std::string& name) {
  const std::string file = last_part(name), folder = fs::path(name).parent_path().string();
  if (file.empty()) return invalid_data("contains a file without a name; copy the recording again");
  auto known = folders_.find(folder);
  if (known == folders_.end()) known = folders_.emplace(folder, own_folder(folder).string()).first;
  std::error_code error;
  fs::create_directories(folder_ / known->second, error);
  if (error)
    return Error{ErrorCode::Internal, (folder_ / known->second).string() + ": cannot be created: " +
                                          error.message() + "; set TMPDIR to another folder"};
  const std::string path = (fs::path(known->second) / file).string();
  paths_[name] = path;
  return folder_ / path;
}

Result<UnpackedFiles> UnpackedFiles::unpack(const RecordingReader& recording) {
  UnpackedFiles unpacked;
  std::ofstream out;
  fs::path path;
  auto done = recording.files([&](const RecordedFilePiece& piece) -> Result<void> {
    if (unpacked.folder_.empty()) {
      std::string made = (fs::temp_directory_path() / "livegs_replay_XXXXXX").string();
      if (::mkdtemp(made.data()) == nullptr)
        return Error{ErrorCode::Internal, made + ": cannot be created: " + std::strerror(errno) +
                                              "; set TMPDIR to another folder"};
      unpacked.folder_ = made;
    }
    if (piece.offset == 0) {
      auto placed = unpacked.place(piece.name);
      if (!placed) return placed.error();
      path = *placed;
      out = std::ofstream(path, std::ios::binary | std::ios::trunc);
    }
    out.write(reinterpret_cast<const char*>(piece.bytes.data()),
              static_cast<std::streamsize>(piece.bytes.size()));
    out.flush();
    if (!out)
      return Error{ErrorCode::Internal, path.string() + ": cannot be written; set TMPDIR to another folder"};
    return {};
  });
  if (!done) return Error{done.error().code, recording.path().string() + ": " + done.error().message};
  return unpacked;
}

std::string UnpackedFiles::path_of(const std::string& given) const {
  const std::string name = without_trailing_slash(given);
  if (const auto file = paths_.find(name); file != paths_.end()) return file->second;
  const auto folder = folders_.find(name);
  return folder == folders_.end() ? given : folder->second;
}

v1::SceneSource UnpackedFiles::placed(v1::SceneSource source) const {
  for_each_path(*source.mutable_file(), [&](std::string& path) { path = path_of(path); });
  return source;
}

v1::SceneChange UnpackedFiles::placed(v1::SceneChange change) const {
  const auto place = [&](std::string& path) { path = path_of(path); };
  if (change.has_environment()) for_each_path(*change.mutable_environment(), place);
  if (change.has_edit() && change.edit().has_after())
    for_each_path(*change.mutable_edit()->mutable_after(), place);
  return change;
}

}  // namespace livegs
