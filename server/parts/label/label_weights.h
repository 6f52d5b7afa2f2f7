// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parts/views/room_view.h"

namespace livegs {

// Sums of alpha times transmittance per kernel and label over views. The label with the largest sum minimises
// the sum over pixels of |label image - blended labels| (FlashSplat, Shen et al. 2024, section 3.2).
class LabelWeights {
 public:
  explicit LabelWeights(size_t kernel_count);

  // Adds one view; weights of one kernel are added in their order.
  void add(std::span<const LabelWeight> weights);

  struct Share {
    uint32_t label = 0;
    float weight = 0;  // of all labels together, px; 0: the kernel was not seen
    float share = 0;   // of the label in the weight
  };
  Share largest(size_t kernel) const;
  size_t size() const { return first_.size(); }

 private:
  static constexpr uint32_t kNone = ~0u;
  struct Entry {
    uint32_t label;
    float weight;
    uint32_t next;  // entry of the same kernel with the next larger label; kNone at the last
  };
  std::vector<uint32_t> first_;  // entry of each kernel with its smallest label; kNone: not seen
  std::vector<Entry> entries_;
};

// Weights of the label pictures of views; one picture per view, rows from the top.
LabelWeights weigh_labels(const DrawnObject& room, std::span<const Camera> cameras,
                          std::span<const std::vector<uint16_t>> pictures);

}  // namespace livegs
