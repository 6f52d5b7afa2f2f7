// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/job/unpack_zip.h"

#include <zip.h>

#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/text/shown_text.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct CloseArchive {
  void operator()(zip_t* zip) const { zip_discard(zip); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

bool stays_inside(const fs::path& name) {
  if (name.empty() || name.is_absolute()) return false;
  for (const fs::path& part : name) {
    if (part == "..") return false;
  }
  return true;
}

// What macOS adds to an archive beside the packed folder, and to each folder: attributes of the files and
// views of the Finder. They are not content, and would hide that the archive has one top folder.
bool is_of_macos(const fs::path& name) {
  return *name.begin() == "__MACOSX" || name.filename() == ".DS_Store";
}

}  // namespace

Result<fs::path> unpack_zip(const fs::path& path, const fs::path& folder) {
  const std::string shown = path.filename().string();
  int code = 0;
  const std::unique_ptr<zip_t, CloseArchive> zip(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (!zip) return invalid_data(shown + ": is not a valid .zip; pack the folder again");
  std::set<fs::path> tops;
  bool top_files = false;
  uint64_t total = 0;
  std::vector<char> piece(1 << 20);
  const zip_int64_t count = zip_get_num_entries(zip.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* raw = zip_get_name(zip.get(), static_cast<zip_uint64_t>(i), 0);
    const std::string name = raw ? raw : "";
    if (!stays_inside(name))
      return invalid_data(shown + ": \"" + shown_text(name, 80) +
                          "\" leads out of its folder; pack the folder again");
    if (is_of_macos(name)) continue;
    const fs::path to = folder / name;
    std::error_code failed;
    const bool is_folder = name.ends_with('/');
    fs::create_directories(is_folder ? to : to.parent_path(), failed);
    if (failed)
      return Error{ErrorCode::Internal, to.string() + ": cannot be created: " + failed.message() +
                                            "; set TMPDIR to another folder"};
    tops.insert(*fs::path(name).begin());
    if (is_folder) continue;
    if (!fs::path(name).has_parent_path()) top_files = true;
    const std::unique_ptr<zip_file_t, CloseArchive> file(
        zip_fopen_index(zip.get(), static_cast<zip_uint64_t>(i), 0));
    if (!file)
      return invalid_data(shown + ": " + shown_text(name, 80) +
                          ": cannot be unpacked; pack the folder again, without a password");
    std::ofstream out(to, std::ios::binary | std::ios::trunc);
    for (;;) {
      const zip_int64_t got = zip_fread(file.get(), piece.data(), piece.size());
      if (got < 0)
        return invalid_data(shown + ": " + shown_text(name, 80) + ": is damaged; pack the folder again");
      if (got == 0) break;
      total += static_cast<uint64_t>(got);
      if (total > kMaxUnpackedBytes)
        return Error{ErrorCode::TooLarge, shown + ": has more than 64 GiB of files; pack fewer"};
      out.write(piece.data(), got);
    }
    out.flush();
    if (!out)
      return Error{ErrorCode::Internal, to.string() + ": cannot be written; free space or set TMPDIR"};
  }
  if (tops.empty()) return invalid_data(shown + ": is empty; pack a folder");
  return top_files || tops.size() != 1 ? folder : folder / *tops.begin();
}

}  // namespace livegs
