// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"

namespace livegs {

// A test pass that rotates words by one place and adds one: word i becomes word i + 1, the last becomes the
// first. Buffers: words, shifted words. Constants: word count.
const Pass& shift_words_pass();
Result<void> dispatch_shift_words(Backend& backend, BufferId words, BufferId shifted, uint32_t count);

}  // namespace livegs
