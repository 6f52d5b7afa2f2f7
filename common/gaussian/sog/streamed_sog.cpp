// SPDX-License-Identifier: Apache-2.0
// Streamed SOG (PlayCanvas, version 1): lod-meta.json lists chunks, each an unbundled .sog, and a tree whose
// leaves name a range of kernels of a chunk for each level of detail. Level 0 is the finest. An object needs
// each leaf once, at its finest level.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/file.h"
#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "gaussian/asset/append_asset.h"
#include "gaussian/asset/file_below.h"
#include "gaussian/asset/readers.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr uint64_t kMaxIndexBytes = uint64_t{256} << 20;

struct KernelRange {
  size_t begin = 0, count = 0;
};

std::optional<size_t> whole_number(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned()) return std::nullopt;
  return found->get<size_t>();
}

class StreamedIndex {
 public:
  StreamedIndex(const Json& json, std::string_view name)
      : json_(json), prefix_(std::string(name) + ": lod-meta.json: ") {}

  Result<std::vector<std::string>> files() const {
    const auto list = json_.find("filenames");
    if (list == json_.end() || !list->is_array() || list->empty())
      return invalid_data(prefix_ + "filenames must be a list of files");
    std::vector<std::string> files;
    for (const Json& entry : *list) {
      if (!entry.is_string() || !is_file_below(entry.get_ref<const std::string&>()))
        return invalid_data(prefix_ + "a name in filenames is not a file below the folder");
      files.push_back(fs::path(entry.get<std::string>()).lexically_normal().generic_string());
    }
    std::set<std::string> distinct(files.begin(), files.end());
    if (distinct.size() != files.size()) return invalid_data(prefix_ + "filenames repeats a file");
    return files;
  }

  // Ranges of the finest level of every leaf, by file.
  Result<std::map<size_t, std::vector<KernelRange>>> finest(size_t file_count) const {
    std::map<size_t, std::vector<KernelRange>> ranges;
    const auto root = json_.find("tree");
    if (root == json_.end() || !root->is_object()) return invalid_data(prefix_ + "has no tree");
    std::vector<const Json*> open = {&*root};
    while (!open.empty()) {
      const Json& node = *open.back();
      open.pop_back();
      const auto children = node.find("children");
      if (children != node.end() && children->is_array()) {
        for (auto child = children->rbegin(); child != children->rend(); ++child) {
          if (!child->is_object()) return invalid_data(prefix_ + "a child in the tree is not an object");
          open.push_back(&*child);
        }
      }
      const auto lods = node.find("lods");
      if (lods == node.end() || !lods->is_object() || lods->empty()) continue;
      const Json* best = nullptr;
      unsigned long best_level = 0;
      for (const auto& [key, lod] : lods->items()) {
        if (key.empty() || key.size() > 9 || key.find_first_not_of("0123456789") != key.npos)
          return invalid_data(prefix_ + "a level in the tree is not a whole number");
        const unsigned long level = std::stoul(key);
        if (!best || level < best_level) best = &lod, best_level = level;
      }
      if (!best->is_object()) return invalid_data(prefix_ + "a level in the tree is not an object");
      const auto file = whole_number(*best, "file"), count = whole_number(*best, "count");
      const size_t offset = whole_number(*best, "offset").value_or(0);
      if (!file || *file >= file_count || !count)
        return invalid_data(prefix_ + "a level in the tree has no valid file or count");
      if (*count > 0) ranges[*file].push_back({offset, *count});
    }
    if (ranges.empty()) return invalid_data(prefix_ + "no level of the tree has kernels");
    return ranges;
  }

 private:
  const Json& json_;
  std::string prefix_;
};

}  // namespace

Result<AssetFile> read_streamed_sog(const fs::path& index, std::string_view name) {
  const auto text = read_text_file(index, kMaxIndexBytes);
  if (!text) return text.error();
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object())
    return invalid_data(std::string(name) + ": lod-meta.json is not a valid JSON object");
  const StreamedIndex reader(json, name);
  const auto files = reader.files();
  if (!files) return files.error();
  const auto ranges = reader.finest(files->size());
  if (!ranges) return ranges.error();

  const fs::path folder = index.has_parent_path() ? index.parent_path() : ".";
  AssetFile whole;
  whole.format = AssetFormat::Sog;
  for (const auto& [number, wanted] : *ranges) {
    const std::string& file = (*files)[number];
    const std::string chunk_name = std::string(name) + ": " + file;
    const auto bundle = [&]() -> Result<AssetFile> {
      const auto bytes = read_file(folder / file);
      if (!bytes) return bytes.error();
      return read_sog_bundle(*bytes, chunk_name);
    };
    const auto chunk = has_ending(file, ".sog") ? bundle() : read_sog_folder(folder / file, chunk_name);
    if (!chunk) return chunk.error();
    // A kernel is taken once, however often the tree names it, so memory is bounded by the chunks.
    std::vector<bool> taken(chunk->asset.size(), false);
    for (const KernelRange& range : wanted) {
      if (range.begin > taken.size() || range.count > taken.size() - range.begin) {
        return invalid_data(std::string(name) + ": lod-meta.json: refers to kernels beyond the " +
                            std::to_string(taken.size()) + " of " + shown_line(file));
      }
      std::fill_n(taken.begin() + static_cast<ptrdiff_t>(range.begin), range.count, true);
    }
    append_asset(whole.asset, chunk->asset, [&](size_t i) { return taken[i]; });
    whole.format_version = chunk->format_version;
    if (whole.frame.up_axis.empty()) whole.frame = chunk->frame;
  }
  whole.notes.push_back("streamed: " + std::to_string(ranges->size()) + " chunks of the finest level, of " +
                        std::to_string(files->size()));
  const auto environment = json.find("environment");
  if (environment != json.end() && environment->is_string())
    whole.notes.push_back("its environment, " + shown_line(environment->get<std::string>()) +
                          ", is left out");
  return whole;
}

}  // namespace livegs
