// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Makes parallel_for on the calling thread run its blocks in order on that thread, with the same result. Used
// by threads that must not take cores from others.
void set_serial_here(bool serial);

}  // namespace livegs
