// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/label/label_weights.h"

#include <utility>

namespace livegs {

LabelWeights::LabelWeights(size_t kernel_count) : first_(kernel_count, kNone) {}

void LabelWeights::add(std::span<const LabelWeight> weights) {
  for (const LabelWeight& w : weights) {
    uint32_t before = kNone, at = first_[w.kernel];
    while (at != kNone && entries_[at].label < w.label) before = std::exchange(at, entries_[at].next);
    if (at != kNone && entries_[at].label == w.label) {
      entries_[at].weight += w.weight;
      continue;
    }
    (before == kNone ? first_[w.kernel] : entries_[before].next) = static_cast<uint32_t>(entries_.size());
    entries_.push_back({w.label, w.weight, at});
  }
}

LabelWeights::Share LabelWeights::largest(size_t kernel) const {
  Share best;
  float most = 0;
  for (uint32_t i = first_[kernel]; i != kNone; i = entries_[i].next) {
    best.weight += entries_[i].weight;
    if (entries_[i].weight > most) {
      most = entries_[i].weight;
      best.label = entries_[i].label;
    }
  }
  if (best.weight > 0) best.share = most / best.weight;
  return best;
}

LabelWeights weigh_labels(const DrawnObject& room, std::span<const Camera> cameras,
                          std::span<const std::vector<uint16_t>> pictures) {
  LabelWeights sums(room.asset->size());
  KernelRasteriser rasteriser;
  std::vector<LabelWeight> weights;
  for (size_t v = 0; v < cameras.size(); ++v) {
    weights.clear();
    rasteriser.weigh(room, cameras[v], pictures[v], weights);
    sums.add(weights);
  }
  return sums;
}

}  // namespace livegs
