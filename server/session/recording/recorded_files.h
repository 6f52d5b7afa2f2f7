// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/recording.pb.h"
#include "recording/recording_reader.h"
#include "recording/recording_writer.h"

namespace livegs {

// The files that a scene refers to: assets, point lists, meshes and hand paths, named as in the scene. Files
// of an asset that is a folder are FOLDER/FILE.
std::vector<std::string> files_of(const v1::SceneSource& source);

// Visits every field that names a file.
void for_each_path(v1::Scene& scene, const std::function<void(std::string& path)>& visit);

// Where a file that a scene names is kept in a copy of the scene: a path inside of the scene's folder is
// unchanged but normal. Files elsewhere keep their places relative to each other, below "elsewhere".
std::string stored_place(const std::string& given);

// Files that an edit of a running scene names, as a separate scene in the same folder.
v1::SceneSource source_of(const v1::SceneChange& change, const std::string& folder);

// Embeds the files that are not in `held`, with their current content. An unreadable file is logged and
// omitted. Fails only if the recording cannot be written.
Result<void> embed_files(const v1::SceneSource& source, std::set<std::string>& held,
                         RecordingWriter& recording);

// The embedded files of a recording, unpacked into a temporary folder that is removed with this object. Names
// from the recording are never used as paths: they may be absolute or contain "../".
class UnpackedFiles {
 public:
  // Empty if the recording contains no files.
  static Result<UnpackedFiles> unpack(const RecordingReader& recording);
  UnpackedFiles(UnpackedFiles&& other) noexcept;
  UnpackedFiles& operator=(UnpackedFiles&&) = delete;
  ~UnpackedFiles();

  bool empty() const { return paths_.empty(); }
  const std::filesystem::path& folder() const { return folder_; }
  // The scene with paths into folder(); paths of files that are not embedded are unchanged.
  v1::SceneSource placed(v1::SceneSource source) const;
  v1::SceneChange placed(v1::SceneChange change) const;

 private:
  UnpackedFiles() = default;
  Result<std::filesystem::path> place(const std::string& name);
  std::string path_of(const std::string& name) const;

  std::filesystem::path folder_;
  std::map<std::string, std::string> paths_;    // paths of files in folder_, by their name in the scene
  std::map<std::string, std::string> folders_;  // paths of their folders, likewise
};

}  // namespace livegs
