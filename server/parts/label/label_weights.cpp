// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/label/label_weights.h"

#include <algorithm>

namespace livegs {

LabelWeights::LabelWeights(size_t kernel_count) : first_(kernel_count + 1, 0) {}

void LabelWeights::add(std::span<const LabelWeight> weights) {
  const size_t kernels = size();
  // Counting sort by kernel; stable.
  std::vector<uint32_t> begin(kernels + 1, 0);
  for (const LabelWeight& w : weights) ++begin[w.kernel + 1];
  for (size_t k = 0; k < kernels; ++k) begin[k + 1] += begin[k];
  std::vector<Entry> sorted(weights.size());
  {
    std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
    for (const LabelWeight& w : weights) sorted[next[w.kernel]++] = {w.label, w.weight};
  }
  std::vector<uint32_t> first(kernels + 1, 0);
  std::vector<Entry> merged;
  merged.reserve(entries_.size() + weights.size());
  for (size_t k = 0; k < kernels; ++k) {
    const size_t start = merged.size();
    merged.insert(merged.end(), entries_.begin() + first_[k], entries_.begin() + first_[k + 1]);
    for (uint32_t i = begin[k]; i < begin[k + 1]; ++i) {
      auto at = merged.begin() + static_cast<std::ptrdiff_t>(start);
      while (at != merged.end() && at->label < sorted[i].label) ++at;
      if (at != merged.end() && at->label == sorted[i].label)
        at->weight += sorted[i].weight;
      else
        merged.insert(at, sorted[i]);
    }
    first[k + 1] = static_cast<uint32_t>(merged.size());
  }
  first_ = std::move(first);
  entries_ = std::move(merged);
}

LabelWeights::Share LabelWeights::largest(size_t kernel) const {
  Share best;
  float most = 0;
  for (uint32_t i = first_[kernel]; i < first_[kernel + 1]; ++i) {
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
