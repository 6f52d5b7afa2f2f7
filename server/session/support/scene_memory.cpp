// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/support/scene_memory.h"

#include <sys/sysinfo.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

#include "core/text/format_text.h"
#include "gaussian/asset_name.h"
#include "gaussian/gltf_files.h"
#include "scene/scene.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// Estimates from the sizes of types, on the low side. A value that is too large refuses scenes that would
// fit. A value that is too small only lets the machine run out of memory.

// Bytes per kernel at the peak of loading: the decoded asset (236 with all colour bands), its .ply and
// progressive encodings, and the points of its body.
constexpr uint64_t kKernelBytes = 800;
// Bytes per body: lattice, surface, search trees and the kernels of a shape.
constexpr uint64_t kBodyBytes = 8u << 20;
// Bytes per client: four frames of 100 kB in flight, the buffers of three connections and 64 waiting events.
constexpr uint64_t kClientBytes = 1u << 20;
// Bytes of the process without a scene: code, gRPC with its threads, material tables.
constexpr uint64_t kServerBytes = 48u << 20;

// Bytes of a kernel in a file: the smallest usual value, so that kernels are overestimated.
constexpr uint64_t kSplatBytes = 32, kSpzBytes = 16, kSogBytes = 10;
// A .ply header has about twenty lines per colour band.
constexpr size_t kMaxHeaderBytes = 16u << 10;

std::optional<uint64_t> number_after(std::string_view text, std::string_view key) {
  const size_t at = text.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  const size_t digits = text.find_first_not_of(" \t", at + key.size());
  uint64_t number = 0;
  if (digits == std::string_view::npos ||
      std::from_chars(text.data() + digits, text.data() + text.size(), number).ec != std::errc())
    return std::nullopt;
  return number;
}

std::string read_text(const fs::path& path, size_t max_bytes) {
  std::ifstream file(path, std::ios::binary);
  std::string text(max_bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(max_bytes));
  text.resize(static_cast<size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return text;
}

uint64_t file_bytes(const fs::path& path) {
  std::error_code error;
  const uint64_t bytes = fs::file_size(path, error);
  return error ? 0 : bytes;
}

uint64_t folder_bytes(const fs::path& folder) {
  std::error_code error;
  uint64_t bytes = 0;
  for (auto at = fs::recursive_directory_iterator(folder, error);
       !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    if (at.depth() >= 2) at.disable_recursion_pending();  // the chunks of a streamed asset
    bytes += file_bytes(at->path());
  }
  return bytes;
}

uint64_t kernels_of(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return folder_bytes(path) / kSogBytes;
  if (is_asset_index(path)) return folder_bytes(path.parent_path()) / kSogBytes;
  const std::string_view ending = asset_ending(path.string()).value_or("");
  if (ending.ends_with(".ply"))
    return number_after(read_text(path, kMaxHeaderBytes), "element vertex").value_or(0);
  uint64_t bytes = file_bytes(path);
  if (ending == ".gltf") {
    for (const std::string& file : gltf_buffer_files(path)) bytes += file_bytes(path.parent_path() / file);
  }
  const uint64_t each = ending == ".splat" || ending == ".glb" || ending == ".gltf" ? kSplatBytes
                        : ending == ".spz"                                          ? kSpzBytes
                                                                                    : kSogBytes;
  return bytes / each;
}

constexpr size_t kMaxStateBytes = 64u << 10;

// The two hierarchies of control groups (kernel documentation, cgroup-v1/memory.rst and cgroup-v2.rst).
struct GroupFiles {
  const char* controller;  // in its line of /proc/self/cgroup
  const char* mount;
  const char* limit;
  const char* used;
  const char* reclaimable;  // a key of memory.stat: cache that counts as used and can be dropped
};
constexpr std::array<GroupFiles, 2> kHierarchies{
    {{"::", "sys/fs/cgroup", "memory.max", "memory.current", "inactive_file "},
     {":memory:", "sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes",
      "total_inactive_file "}}};

uint64_t left_in_group(const fs::path& group, const GroupFiles& files) {
  constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();
  const auto limit = number_after(read_text(group / files.limit, kMaxStateBytes), "");  // "max": no limit
  const auto used = number_after(read_text(group / files.used, kMaxStateBytes), "");
  if (!limit || !used) return kNoLimit;
  const uint64_t reclaimable =
      number_after(read_text(group / "memory.stat", kMaxStateBytes), files.reclaimable).value_or(0);
  const uint64_t held = *used - std::min(*used, reclaimable);
  return *limit - std::min(*limit, held);
}

// A group's limit applies to all groups below it. In a container the group's own folder may be the mount
// root.
uint64_t left_in_groups(const fs::path& root) {
  uint64_t left = std::numeric_limits<uint64_t>::max();
  const std::string groups = read_text(root / "proc/self/cgroup", kMaxStateBytes);
  for (const GroupFiles& files : kHierarchies) {
    const size_t at = groups.find(files.controller);
    if (at == std::string::npos) continue;
    const size_t from = groups.find('/', at);
    if (from == std::string::npos) continue;
    fs::path group = fs::path(groups.substr(from, groups.find('\n', from) - from)).relative_path();
    for (;; group = group.parent_path()) {
      left = std::min(left, left_in_group(root / files.mount / group, files));
      if (group.empty()) break;
    }
  }
  return left;
}

uint64_t machine_bytes() {
  struct sysinfo machine {};
  return ::sysinfo(&machine) == 0 ? static_cast<uint64_t>(machine.totalram) * machine.mem_unit
                                  : std::numeric_limits<uint64_t>::max();
}

}  // namespace

SceneSize scene_size(const v1::Scene& file, const fs::path& folder, size_t clients) {
  SceneSize size{.kernels = 0, .bodies = static_cast<size_t>(file.objects_size()), .clients = clients};
  if (!file.environment().asset().empty()) size.kernels += kernels_of(folder / file.environment().asset());
  for (const v1::Object& object : file.objects()) {
    if (!object.asset().empty()) size.kernels += kernels_of(folder / object.asset());
  }
  return size;
}

uint64_t scene_bytes(const SceneSize& size) {
  return kServerBytes + size.kernels * kKernelBytes + size.bodies * kBodyBytes + size.clients * kClientBytes;
}

uint64_t free_bytes(const fs::path& root) {
  const auto available_kb = number_after(read_text(root / "proc/meminfo", kMaxStateBytes), "MemAvailable:");
  return std::min(available_kb ? *available_kb * 1024 : machine_bytes(), left_in_groups(root));
}

Result<void> check_memory(uint64_t needed_bytes, uint64_t free_bytes) {
  if (needed_bytes <= free_bytes) return {};
  constexpr double kMb = 1e-6;
  return Error{ErrorCode::Unavailable,
               format_text("scene: needs about %.0f MB, %.0f MB are free; use fewer or smaller assets, fewer "
                           "--clients, or a machine with more memory",
                           kMb * static_cast<double>(needed_bytes), kMb * static_cast<double>(free_bytes))};
}

Result<void> check_scene_memory(const fs::path& path, size_t clients) {
  const auto text = read_scene(path);
  if (!text) return {};
  return check_memory(scene_bytes(scene_size(text->file, text->folder, clients)), free_bytes());
}

}  // namespace livegs
