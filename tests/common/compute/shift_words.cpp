// SPDX-License-Identifier: Apache-2.0
#include "common/compute/shift_words.h"

#include <algorithm>
#include <array>

#include "compute/pass_rows.h"
#include "shift_words.spv.h"

namespace livegs {
namespace {

void shift_words(const PassArguments& arguments, size_t begin, size_t end) {
  const auto count = row_at<uint32_t>(arguments.constants, 0);
  for (size_t i = begin; i < std::min<size_t>(end, count); ++i)
    words_of(arguments.buffers[1])[i] = words_of(arguments.buffers[0])[(i + 1) % count] + 1;
}

}  // namespace

const Pass& shift_words_pass() {
  static const Pass pass{.name = "shift_words",
                         .group_size = 64,
                         .buffer_count = 2,
                         .constants_bytes = sizeof(uint32_t),
                         .spirv = shift_words_spirv,
                         .run = shift_words};
  return pass;
}

Result<void> dispatch_shift_words(Backend& backend, BufferId words, BufferId shifted, uint32_t count) {
  const std::array buffers{words, shifted};
  return backend.dispatch(shift_words_pass(), buffers, std::as_bytes(std::span(&count, 1)), count);
}

}  // namespace livegs
