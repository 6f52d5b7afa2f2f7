// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/cells_body.h"

namespace livegs {

void CellsBody::flow() {}

}  // namespace livegs
