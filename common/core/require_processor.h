// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Exits with code 1 and one line on standard error if the processor lacks the instruction set of the build
// (LIVEGS_ARCH), instead of failing with an illegal instruction. The check runs before all static
// initialisation; main calls this function only so that it is linked.
void require_processor();

}  // namespace livegs
