// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.h"
#include "stream/received/received.h"

namespace livegs {

// Checked: the rest body decodes, the hash is one (64 hexadecimal digits: it becomes a file name), the size
// is within what may be read.
Result<StreamedObject> read_description(const v1::ObjectDescription& description);

}  // namespace livegs
