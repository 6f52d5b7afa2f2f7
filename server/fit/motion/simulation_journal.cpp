// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/simulation_journal.h"

#include <cstdint>
#include <cstring>

namespace livegs {
namespace {

// Before each result: length of the key and the fields of PointPaths.
struct Head {
  uint64_t key_bytes = 0;
  double rate_hz = 0;
  uint64_t points = 0, positions = 0;
};
constexpr size_t kPositionBytes = 3 * sizeof(float);
// Largest sum of the results, bytes; later ones are not kept. Larger: more memory and traffic; smaller: long
// fits repeat their last simulations.
constexpr size_t kMaxBytes = size_t{1} << 30;

}  // namespace

size_t SimulationJournal::size() const {
  std::lock_guard lock(mutex_);
  return results_.size();
}

std::optional<PointPaths> SimulationJournal::find(const std::string& key) const {
  std::lock_guard lock(mutex_);
  const auto found = results_.find(key);
  if (found == results_.end()) return std::nullopt;
  return found->second;
}

void SimulationJournal::add(const std::string& key, const PointPaths& paths) {
  std::lock_guard lock(mutex_);
  const size_t size = sizeof(Head) + key.size() + kPositionBytes * paths.positions_m.size();
  if (paths.ticks() == 0 || bytes_ + size > kMaxBytes) return;
  if (results_.emplace(key, paths).second) bytes_ += size;
}

std::vector<std::byte> SimulationJournal::bytes() const {
  std::lock_guard lock(mutex_);
  std::vector<std::byte> all;
  all.reserve(bytes_);
  const auto append = [&](const void* data, size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    all.insert(all.end(), begin, begin + size);
  };
  for (const auto& [key, paths] : results_) {
    const Head head{key.size(), paths.rate_hz, paths.points, paths.positions_m.size()};
    append(&head, sizeof head);
    append(key.data(), key.size());
    append(paths.positions_m.data(), kPositionBytes * paths.positions_m.size());
  }
  return all;
}

Result<void> SimulationJournal::read(std::span<const std::byte> bytes) {
  std::map<std::string, PointPaths> results;
  while (!bytes.empty()) {
    const Error damaged = invalid_data("checkpoint: is damaged; the fit begins again");
    Head head;
    if (bytes.size() < sizeof head) return damaged;
    std::memcpy(&head, bytes.data(), sizeof head);
    bytes = bytes.subspan(sizeof head);
    if (head.key_bytes > bytes.size() || head.positions > (bytes.size() - head.key_bytes) / kPositionBytes ||
        head.points == 0 || head.positions == 0 || head.positions % head.points != 0 || !(head.rate_hz > 0))
      return damaged;
    const std::string key(reinterpret_cast<const char*>(bytes.data()), head.key_bytes);
    bytes = bytes.subspan(head.key_bytes);
    PointPaths paths;
    paths.rate_hz = head.rate_hz;
    paths.points = head.points;
    paths.positions_m.resize(head.positions);
    std::memcpy(paths.positions_m.data(), bytes.data(), kPositionBytes * head.positions);
    bytes = bytes.subspan(kPositionBytes * head.positions);
    results.emplace(key, std::move(paths));
  }
  for (const auto& [key, paths] : results) add(key, paths);
  return {};
}

}  // namespace livegs
