// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stream/received/received.h"

namespace livegs {

// One line about an object: type, mass, and for an elastic object the accuracy of its stiffness at the cells
// and substeps chosen by the server.
std::string object_summary(const StreamedObject& object);

}  // namespace livegs
