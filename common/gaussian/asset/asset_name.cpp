// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_name.h"

#include "core/text/path_ending.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// Longer endings come first.
constexpr std::string_view kSplatEndings[] = {".compressed.ply", ".ply", ".spz", ".sog",
                                              ".splat",          ".glb", ".gltf"};

}  // namespace

std::optional<std::string_view> asset_ending(std::string_view name) {
  const size_t slash = name.find_last_of('/');
  if (slash != name.npos) name.remove_prefix(slash + 1);
  for (const std::string_view ending : kSplatEndings) {
    if (name.size() > ending.size() && has_ending(name, ending)) return ending;
  }
  return std::nullopt;
}

bool is_asset_index(const fs::path& path) {
  const std::string name = lower_case(path.filename().string());
  return name == "meta.json" || name == "lod-meta.json";
}

std::optional<fs::path> asset_index(const fs::path& folder) {
  std::error_code error;
  std::optional<fs::path> found;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (!is_asset_index(entry->path())) continue;
    // A streamed asset has only lod-meta.json at its top; the longer name wins in a folder with both.
    if (!found || entry->path().filename().string().size() > found->filename().string().size())
      found = entry->path();
  }
  return found;
}

fs::path asset_stem(const fs::path& path) {
  if (is_asset_index(path)) return path.parent_path();
  const auto ending = asset_ending(path.string());
  if (!ending) return path;
  const std::string text = path.string();
  return text.substr(0, text.size() - ending->size());
}

}  // namespace livegs
