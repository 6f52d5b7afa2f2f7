// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/capture/place_photos.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <vector>

#include "capture/read/pose_files.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// All pairs of photos are matched, so the time grows with the square of their number.
constexpr size_t kMaxPlacedPhotos = 1000;

bool is_photo(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png";
}

size_t count_photos(const fs::path& folder) {
  std::error_code error;
  size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder, error)) count += is_photo(entry.path());
  return count;
}

// Runs colmap with its output in `log`. Ctrl-C also ends colmap, which is in the same process group.
Result<void> run_colmap(std::vector<std::string> words, const fs::path& log) {
  words.insert(words.begin(), "colmap");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  // Qt requires a display even if none is used.
  std::string platform = "QT_QPA_PLATFORM=offscreen";
  std::vector<char*> environment;
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (!std::string_view(*entry).starts_with("QT_QPA_PLATFORM=")) environment.push_back(*entry);
  environment.push_back(platform.data());
  environment.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t process = -1;
  const int failed =
      posix_spawnp(&process, "colmap", &actions, nullptr, arguments.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    return not_found(
        "colmap: cannot be started; install it (Debian package colmap), or give photos with poses");
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return Error{ErrorCode::Unavailable, "colmap " + words[1] + ": failed; its output is in " + log.string()};
}

// The folder and size of the model with the most photos; colmap numbers its models.
std::pair<fs::path, size_t> largest_model(const fs::path& models) {
  std::pair<fs::path, size_t> best{{}, 0};
  for (int number = 0; has_colmap_model(models / std::to_string(number)); ++number) {
    const fs::path folder = models / std::to_string(number);
    if (const auto model = read_colmap_model(folder); model && model->views.size() > best.second)
      best = {folder, model->views.size()};
  }
  return best;
}

}  // namespace

Result<fs::path> photo_folder(const fs::path& photos) {
  for (const fs::path& folder : {photos / "images", photos})
    if (count_photos(folder) > 0) return folder;
  return not_found(photos.string() + ": has no photos; give a folder of .jpg or .png files");
}

Result<Capture> place_photos(const fs::path& photos, const fs::path& work) {
  auto folder = photo_folder(photos);
  if (!folder) return folder.error();
  const size_t count = count_photos(*folder);
  if (count < kMinCapturedViews || count > kMaxPlacedPhotos)
    return invalid_data(format_text("%s: has %zu photos; give %zu to %zu", photos.c_str(), count,
                                    kMinCapturedViews, kMaxPlacedPhotos));
  const fs::path database = work / "colmap.db", models = work / "models", log = work / "colmap.log";
  std::error_code error;
  if (largest_model(models).second == 0) {
    fs::remove(database, error);
    fs::remove(log, error);
    fs::remove_all(models, error);
    fs::create_directories(models, error);
    if (error) return file_error(models, "cannot be created", error);
    const auto step = [&](const std::string& does, std::vector<std::string> words) {
      log_info("poses of %zu photos: %s", count, does.c_str());
      return run_colmap(std::move(words), log);
    };
    if (auto ran = step("finding features (1 of 3)",
                        {"feature_extractor", "--database_path", database.string(), "--image_path",
                         folder->string(), "--ImageReader.single_camera", "1", "--ImageReader.camera_model",
                         "OPENCV", "--SiftExtraction.use_gpu", "0"});
        !ran)
      return ran.error();
    if (auto ran =
            step(format_text("matching %zu pairs (2 of 3)", count * (count - 1) / 2),
                 {"exhaustive_matcher", "--database_path", database.string(), "--SiftMatching.use_gpu", "0"});
        !ran)
      return ran.error();
    if (auto ran =
            step("placing cameras (3 of 3)", {"mapper", "--database_path", database.string(), "--image_path",
                                              folder->string(), "--output_path", models.string()});
        !ran && largest_model(models).second == 0) {
      return invalid_data(photos.string() +
                          ": no photos could be placed; take photos that overlap by two thirds and show "
                          "texture");
    }
  }
  const auto [best, placed] = largest_model(models);
  if (2 * placed < count || placed < kMinCapturedViews)
    return invalid_data(format_text(
        "%s: only %zu of %zu photos could be placed together; take photos of one place that overlap by two "
        "thirds",
        photos.c_str(), placed, count));
  // The layout that read_capture expects.
  const fs::path root = work / "placed";
  fs::remove_all(root, error);
  fs::create_directories(root / "sparse", error);
  fs::create_directory_symlink(fs::absolute(*folder), root / "images", error);
  fs::create_directory_symlink(fs::absolute(best), root / "sparse" / "0", error);
  if (error) return file_error(root, "cannot be written", error);
  auto capture = read_capture(root);
  if (!capture) return capture.error();
  for (CapturedView& view : capture->views) view.picture = fs::canonical(view.picture, error);
  if (placed < count)
    capture->notes.push_back(format_text("%zu of %zu photos could not be placed", count - placed, count));
  return capture;
}

}  // namespace livegs
