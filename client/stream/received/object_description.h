// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.h"
#include "stream/received/received.h"

namespace livegs {

// Parses and validates a description: the rest body decodes, each hash is 64 hexadecimal digits (it becomes a
// file name), and the asset size is within limits.
Result<StreamedObject> read_description(const v1::ObjectDescription& description);

}  // namespace livegs
