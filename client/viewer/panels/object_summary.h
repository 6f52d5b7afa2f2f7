// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stream/received/received.h"

namespace livegs {

// An object in one line, for a person: what it is, its mass, and, when it is elastic, how far its stiffness
// can be trusted at the cells and substeps the server chose.
std::string object_summary(const StreamedObject& object);

}  // namespace livegs
