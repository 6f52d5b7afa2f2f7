// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Ends the program with exit code 1 and one line on stderr if this processor lacks the instruction set that
// the programs are compiled for (LIVEGS_ARCH); without the check they would end with an illegal instruction.
// The check runs before all static initialisation. main calls the function so that it is linked.
void require_processor();

}  // namespace livegs
