// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/stored/publish_scene.h"

#include <google/protobuf/util/json_util.h>

#include <map>
#include <set>
#include <span>

#include "analysis/physics_file.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "gaussian/stored_blocks.h"
#include "livegs/v1/store.pb.h"
#include "scene/check/sidecar_paths.h"
#include "scene/edit/scene_document.h"
#include "scene/scene.h"
#include "session/assets/asset_store.h"
#include "session/recording/recorded_files.h"
#include "web/content_coding.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSceneEnding = ".scene.json";

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

class Publisher {
 public:
  Publisher(ObjectStore& store, const PublishOptions& options) : store_(store), options_(options) {}

  // A file at `path` relative to the scene file.
  Result<void> add_file(const std::string& path, std::span<const std::byte> bytes) {
    const std::string hash = content_hash(bytes);
    const auto [known, fresh] = hashes_.emplace(path, hash);
    if (!fresh && known->second != hash)
      return invalid_argument(path + ": two files have this place in the store; rename one of them");
    if (!fresh) return {};
    v1::StoredScene::File& file = *list_.add_files();
    file.set_path(path);
    file.set_sha256(hash);
    file.set_bytes(bytes.size());
    ++published_.files;
    return put_once(hash, bytes);
  }

  Result<void> add_asset(const GaussianAsset& asset) {
    const AssetBytes encoded = encode_asset(asset);
    if (!assets_.insert(encoded.hash).second) return {};
    v1::StoredScene::Asset& entry = *list_.add_assets();
    entry.set_hash(encoded.hash);
    entry.set_bytes(encoded.bytes.size());
    ++published_.assets;
    // An asset has the name of its .ply, which may be a file of the scene; the transfer form has its own
    // folder.
    if (auto put = put_once(kAssetFolder + encoded.hash, encoded.bytes); !put) return put;
    const auto blocks = store_blocks(encoded.bytes);
    if (!blocks) return blocks.error();
    const auto coded = encode_content(*blocks, ContentCoding::Gzip);
    if (!coded) return coded.error();
    entry.set_web_sha256(content_hash(*coded));
    return put_once(kAssetFolder + entry.web_sha256(), *coded);
  }

  Result<PublishedScene> finish(const std::string& name, std::span<const std::byte> scene) {
    published_.file = name + std::string(kSceneEnding);
    if (auto added = add_file(published_.file, scene); !added) return added.error();
    if (auto put = store_.put(published_.file, scene); !put) return put.error();
    google::protobuf::util::JsonPrintOptions print;
    print.add_whitespace = true;
    print.preserve_proto_field_names = true;
    std::string text;
    if (!google::protobuf::util::MessageToJsonString(list_, &text, print).ok())
      return Error{ErrorCode::Internal, name + ": the list of files cannot be written"};
    if (options_.before_list) {
      if (auto noted = options_.before_list(content_hash(bytes_of(text))); !noted) return noted.error();
    }
    if (auto put = store_.put(name + ".files.json", bytes_of(text)); !put) return put.error();
    return published_;
  }

 private:
  Result<void> put_once(const std::string& name, std::span<const std::byte> bytes) {
    const auto size = store_.size(name);
    if (!size) return size.error();
    bool right = *size == bytes.size();
    if (right && options_.verify) {
      const auto hash = store_.hash(name);
      if (!hash) return hash.error();
      published_.read_bytes += bytes.size();
      right = *hash == content_hash(bytes);
      if (!right) {
        log_warn("%s: its bytes have another hash; replacing it", store_.shown(name).c_str());
        ++published_.replaced;
      }
    }
    if (!right) {
      if (auto put = store_.put(name, bytes); !put) return put;
      published_.written_bytes += bytes.size();
    }
    if (options_.progress) options_.progress(published_);
    return {};
  }

  static inline const std::string kAssetFolder = "assets/";
  ObjectStore& store_;
  const PublishOptions& options_;
  v1::StoredScene list_;
  PublishedScene published_;
  std::map<std::string, std::string> hashes_;  // of files, by path
  std::set<std::string> assets_;
};

// The name of the scene without endings.
std::string name_of(const SceneText& text) {
  std::string name = text.name;
  if (has_ending(name, std::string(kSceneEnding))) name.resize(name.size() - kSceneEnding.size());
  return name.empty() || name == "/" ? "scene" : name;
}

}  // namespace

Result<PublishedScene> publish_scene(const fs::path& path, ObjectStore& store,
                                     const PublishOptions& options) {
  auto text = read_scene(path);
  if (!text) return text.error();
  auto scene = Scene::build(text->file, text->folder, text->name, {});
  if (!scene) return Error{scene.error().code, text->name + ": " + scene.error().message};

  Publisher publisher(store, options);
  const auto add = [&](const std::string& given) -> Result<void> {
    const auto bytes = read_file(text->folder / given);
    if (!bytes) return bytes.error();
    return publisher.add_file(stored_place(given), *bytes);
  };
  const v1::SceneSource source = scene->source();
  for (const std::string& given : files_of(source)) {
    if (auto added = add(given); !added) return added.error();
  }
  for (const fs::path& sidecar : sidecar_paths(text->file, text->folder, text->name)) {
    std::error_code ignored;
    if (sidecar.empty()) continue;
    for (const fs::path& file : {sidecar, physics_log_path(sidecar)}) {
      if (!fs::is_regular_file(file, ignored)) continue;
      if (auto added = add(file.lexically_relative(text->folder.empty() ? "." : text->folder).string());
          !added)
        return added.error();
    }
  }
  if (auto added = publisher.add_asset(*Scene::ball_asset()); !added) return added.error();
  for (const SceneObject& object : scene->objects()) {
    if (auto added = publisher.add_asset(*object.asset); !added) return added.error();
    if (!object.broken) continue;
    if (auto added = publisher.add_asset(*object.broken->asset); !added) return added.error();
  }
  // The file as it is, unless it names files elsewhere.
  bool moved = !text->of_file;
  v1::Scene placed = text->file;
  for_each_path(placed, [&](std::string& given) {
    std::error_code ignored;
    const bool folder = fs::is_directory(text->folder / given, ignored);
    const std::string place =
        folder ? fs::path(stored_place(given + "/file")).parent_path().string() : stored_place(given);
    moved = moved || place != (fs::path(given) / "").lexically_normal().parent_path();
    given = place;
  });
  if (!moved) {
    const auto bytes = read_file(text->folder / text->name);
    if (!bytes) return bytes.error();
    return publisher.finish(name_of(*text), *bytes);
  }
  const auto written = scene_text(placed);
  if (!written) return written.error();
  return publisher.finish(name_of(*text), bytes_of(*written));
}

}  // namespace livegs
