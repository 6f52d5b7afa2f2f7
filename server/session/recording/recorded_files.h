// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/recording.pb.h"
#include "recording/recording_reader.h"
#include "recording/recording_writer.h"

namespace livegs {

// The files that a scene is built from, besides its own: assets, lists of points, meshes and paths of hands,
// named as the scene names them. Those of an asset that is a folder are FOLDER/FILE.
std::vector<std::string> files_of(const v1::SceneSource& source);

// Writes those into a recording that it does not hold yet, as they are on the disk now. One that cannot be
// read is told in the log and left out. Fails only with the recording.
Result<void> embed_files(const v1::SceneSource& source, std::set<std::string>& held,
                         RecordingWriter& recording);

// The files that a recording holds, in a folder of their own that goes with this. What a scene calls them is
// never taken for a path: it may be anywhere, or "../".
class UnpackedFiles {
 public:
  // Without any file when the recording holds none.
  static Result<UnpackedFiles> unpack(const RecordingReader& recording);
  UnpackedFiles(UnpackedFiles&& other) noexcept;
  UnpackedFiles& operator=(UnpackedFiles&&) = delete;
  ~UnpackedFiles();

  bool empty() const { return paths_.empty(); }
  const std::filesystem::path& folder() const { return folder_; }
  // The scene with the paths that its files have in folder(); what is not there keeps its own.
  v1::SceneSource placed(v1::SceneSource source) const;

 private:
  UnpackedFiles() = default;
  Result<std::filesystem::path> place(const std::string& name);
  std::string path_of(const std::string& name) const;

  std::filesystem::path folder_;
  std::map<std::string, std::string> paths_;    // of files, within folder_, by the scene's name for them
  std::map<std::string, std::string> folders_;  // likewise, of their folders
};

}  // namespace livegs
