// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"

namespace livegs {

// A pass for tests of what runs passes: word i becomes word i + 1, the last the first, plus one. Buffers:
// words, shifted words. Constants: how many.
const Pass& shift_words_pass();
Result<void> dispatch_shift_words(Backend& backend, BufferId words, BufferId shifted, uint32_t count);

}  // namespace livegs
