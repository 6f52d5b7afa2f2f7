// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/stored/stored_scene.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "json/json_message.h"
#include "livegs/v1/store.pb.h"
#include "scene/scene.h"
#include "session/recording/recorded_files.h"
#include "store/object_store.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxListBytes = 64 << 20;

std::string without_scene_ending(std::string name) {
  constexpr std::string_view kEnding = ".scene.json";
  if (has_ending(name, std::string(kEnding))) name.resize(name.size() - kEnding.size());
  return name;
}

bool is_hash(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// Whether a path of the list stays in the folder of the scene.
bool is_inside(const std::string& path) {
  const fs::path given(path);
  if (path.empty() || path.find('\0') != std::string::npos || given.is_absolute()) return false;
  for (const fs::path& part : given) {
    if (part == ".." || part.empty()) return false;
  }
  return true;
}

// `hash`: of the list.
Result<v1::StoredScene> read_list(ObjectStore& store, const std::string& name, std::string& hash,
                                  std::stop_token stop) {
  auto bytes = store.get(name, kMaxListBytes, stop);
  if (!bytes)
    return Error{bytes.error().code, bytes.error().message + (bytes.error().code == ErrorCode::NotFound
                                                                  ? "; store the scene with livegs publish"
                                                                  : "")};
  hash = content_hash(*bytes);
  v1::StoredScene list;
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  if (auto parsed = parse_json_message(text, list); !parsed)
    return invalid_data(store.shown(name) + ": " + parsed.error().message);
  for (const auto& file : list.files()) {
    if (!is_inside(file.path()) || !is_hash(file.sha256()))
      return invalid_data(store.shown(name) + ": \"" + shown_text(file.path(), 80) +
                          "\" is not a file of a scene; publish the scene again");
  }
  for (const auto& asset : list.assets()) {
    if (!is_hash(asset.hash()))
      return invalid_data(store.shown(name) + ": an asset has no hash; publish the scene again");
  }
  return list;
}

// A scene of a store names files in its own folder only: no file of this machine is for its clients.
Result<void> check_paths(const fs::path& path, const std::string& shown) {
  auto text = read_scene(path);
  if (!text) return text.error();
  std::string outside;
  livegs::for_each_path(text->file, [&](std::string& given) {
    // Without the parts that cancel out, and the slash of a folder.
    if (!is_inside((fs::path(given) / "").lexically_normal().parent_path().string())) outside = given;
  });
  if (outside.empty()) return {};
  return invalid_data(shown + ": \"" + shown_text(outside, 80) +
                      "\" is outside the folder of the scene; publish the scene again");
}

Result<void> fetch_file(ObjectStore& store, const v1::StoredScene::File& file, const fs::path& folder,
                        std::stop_token stop) {
  const fs::path path = folder / file.path();
  std::error_code failed;
  fs::create_directories(path.parent_path(), failed);
  if (failed)
    return Error{ErrorCode::Internal, path.parent_path().string() + ": cannot be created: " +
                                          failed.message() + "; set TMPDIR to another folder"};
  // Hidden and unique: the folder may be the user's, and another server may fetch the same file.
  const fs::path part =
      path.parent_path() / ("." + file.sha256() + "." + std::to_string(::getpid()) + ".part");
  const struct Remove {
    const fs::path& path;
    ~Remove() {
      std::error_code ignored;
      fs::remove(path, ignored);
    }
  } remove_at_end{part};
  if (auto read = store.read_to_file_by_hash(file.sha256(), part, stop); !read)
    return Error{read.error().code, file.path() + ": " + read.error().message};
  fs::rename(part, path, failed);
  if (failed) return file_error(path, "cannot be written", failed);
  return {};
}

}  // namespace

StoredScene::StoredScene(StoredScene&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      list_name_(std::move(other.list_name_)),
      list_hash_(std::move(other.list_hash_)),
      assets_(std::move(other.assets_)) {}

StoredScene::~StoredScene() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

Result<bool> StoredScene::is_current(ObjectStore& store) const {
  const auto hash = store.hash(list_name_);
  if (!hash) return hash.error();
  return *hash == list_hash_;
}

Result<StoredScene> StoredScene::fetch(const std::string& scene, const std::string& place,
                                       std::stop_token stop) {
  const bool remote = is_store_url(scene);
  const auto at = remote ? open_object(scene) : Result<ObjectPlace>(ObjectPlace{});
  if (!at) return at.error();
  auto store = place.empty() ? at->store : nullptr;
  if (!store) {
    auto opened = ObjectStore::open(place);
    if (!opened) return opened.error();
    store = *std::move(opened);
  }
  const fs::path local = fs::absolute(scene).lexically_normal();
  std::string name = at->name;
  if (!remote) name = (local.has_filename() ? local : local.parent_path()).filename().string();
  if (remote && !has_ending(name, ".scene.json"))
    return invalid_argument(shown_url(scene) +
                            ": is not the address of a NAME.scene.json; give that of livegs publish");
  ObjectStore& lists = remote ? *at->store : *store;
  StoredScene fetched;
  fetched.list_name_ = without_scene_ending(name) + ".files.json";
  const auto list = read_list(lists, fetched.list_name_, fetched.list_hash_, stop);
  if (!list) return list.error();
  for (const auto& asset : list->assets()) fetched.assets_.push_back({asset.hash(), asset.web_sha256()});
  fs::path folder;
  if (remote) {
    std::string made = (fs::temp_directory_path() / "livegs_scene_XXXXXX").string();
    if (::mkdtemp(made.data()) == nullptr)
      return Error{ErrorCode::Internal,
                   made + ": cannot be created: " + std::strerror(errno) + "; set TMPDIR to another folder"};
    fetched.temporary_ = folder = made;
    fetched.path_ = folder / name;
  } else {
    std::error_code ignored;
    folder = fs::is_directory(local, ignored) ? local : local.parent_path();
    fetched.path_ = scene;
  }
  size_t count = 0;
  uint64_t bytes = 0;
  for (const auto& file : list->files()) {
    std::error_code ignored;
    if (!remote && (fs::exists(folder / file.path(), ignored) || has_ending(file.path(), ".scene.json")))
      continue;
    if (auto done = fetch_file(*store, file, folder, stop); !done) return done.error();
    ++count;
    bytes += file.bytes();
  }
  std::error_code ignored;
  if (remote && !fs::exists(fetched.path_, ignored))
    return invalid_data(shown_url(scene) + ": its list of files lacks the scene; publish the scene again");
  if (remote) {
    if (auto checked = check_paths(fetched.path_, shown_url(scene)); !checked) return checked.error();
  }
  if (count > 0) log_info("store: %zu files fetched, %.1f MB", count, static_cast<double>(bytes) * 1e-6);
  return fetched;
}

}  // namespace livegs
