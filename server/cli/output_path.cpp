// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/output_path.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

namespace livegs {
namespace {

std::string lower_case_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

}  // namespace

Result<void> check_output_file(const std::filesystem::path& path,
                               std::initializer_list<const char*> endings) {
  const std::string ending = lower_case_ending(path);
  std::string list;
  for (const char* one : endings) {
    if (ending == one) return {};
    list += (list.empty() ? "" : " or ") + std::string(one);
  }
  return invalid_argument(path.string() + ": cannot be written" +
                          (ending.empty() ? " without an ending" : " as " + ending) + "; use " + list);
}

Result<void> check_output_folder(const std::filesystem::path& path) {
  static constexpr const char* kFormats[] = {".bmp",  ".csv",  ".gif",  ".glb",   ".gltf", ".html",
                                             ".jpeg", ".jpg",  ".json", ".mp4",   ".obj",  ".ply",
                                             ".png",  ".ppm",  ".sog",  ".splat", ".spz",  ".stl",
                                             ".tif",  ".tiff", ".usd",  ".usda",  ".usdz", ".webp"};
  std::error_code ignored;
  const std::string ending = lower_case_ending(path);
  const bool file =
      std::any_of(std::begin(kFormats), std::end(kFormats), [&](const char* one) { return ending == one; });
  if (file && !std::filesystem::is_directory(path, ignored))
    return invalid_argument(path.string() +
                            ": is the name of a file, but several files are written; give a "
                            "folder, without " +
                            ending);
  if (path.empty()) return {};  // an output that was not asked for
  std::filesystem::path there = std::filesystem::absolute(path, ignored).lexically_normal();
  while (!std::filesystem::exists(there, ignored) && there != there.parent_path())
    there = there.parent_path();
  if (!std::filesystem::is_directory(there, ignored))
    return invalid_argument(path.string() + ": cannot be a folder, because " + there.string() +
                            " is a file; give another folder");
  if (::access(there.c_str(), W_OK) != 0)
    return Error{ErrorCode::PermissionDenied,
                 path.string() + ": cannot be written: " + std::strerror(errno) + "; give another folder"};
  return {};
}

}  // namespace livegs
