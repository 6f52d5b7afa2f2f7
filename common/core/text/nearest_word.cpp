// SPDX-License-Identifier: Apache-2.0
#include "core/text/nearest_word.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/text/lower_case.h"

namespace livegs {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before = std::exchange(last, now);
  }
  return last[b.size()];
}

std::string_view nearest_word(std::string_view word, std::span<const std::string> words) {
  constexpr std::size_t kMaxLength = 100;  // a longer word is near nothing
  if (word.size() > kMaxLength) return {};
  std::string_view nearest;
  std::size_t steps = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& one : words) {
    const std::size_t distance = edit_distance(lower_case(word), lower_case(one));
    if (distance >= steps) continue;
    steps = distance;
    nearest = one;
  }
  return nearest;
}

}  // namespace livegs
