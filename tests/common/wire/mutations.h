// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <random>
#include <span>
#include <vector>

namespace livegs::testing {

// Calls `look` with `count` mutated copies of `bytes`: one to four overwritten bytes, flipped bits, a removed
// range, a repeated range or a removed tail. Deterministic for a seed.
inline void for_each_mutation(const std::vector<std::byte>& bytes, int count, uint64_t seed,
                              const std::function<void(std::span<const std::byte>)>& look) {
  std::mt19937_64 random(seed);
  for (int i = 0; i < count; ++i) {
    std::vector<std::byte> spoilt = bytes;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int change = 0; change < changes && !spoilt.empty(); ++change) {
      const size_t at = random() % spoilt.size();
      const auto place = spoilt.begin() + static_cast<std::ptrdiff_t>(at);
      const auto stretch = static_cast<std::ptrdiff_t>(random() % std::min<size_t>(16, spoilt.size() - at));
      switch (random() % 6) {
        case 0:
          spoilt[at] = static_cast<std::byte>(random());
          break;
        case 1:
          spoilt[at] ^= static_cast<std::byte>(1u << (random() % 8));
          break;
        case 2:
          spoilt[at] = std::byte{0xFF};
          break;
        case 3:
          spoilt.erase(place, place + stretch);
          break;
        case 4: {
          const std::vector<std::byte> again(place, place + stretch);
          spoilt.insert(place, again.begin(), again.end());
          break;
        }
        case 5:
          spoilt.resize(at);
          break;
      }
    }
    look(spoilt);
  }
}

}  // namespace livegs::testing
