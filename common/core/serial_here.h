// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// From now on parallel_for on the calling thread does its blocks by itself, one after the other, with the
// same result: for threads that must not take cores from others.
void set_serial_here(bool serial);

}  // namespace livegs
