// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <google/protobuf/message.h>

#include <string_view>

#include "core/result.h"

namespace livegs {

// Parses a file that a user wrote: JSON with // and /* */ comments, whose fields are those of `message`. The
// error is one line, to be appended to the file name: the position, the field, the problem and the nearest
// right word. Examples:
//   line 3, column 7: objects[0]: unknown field "nme"; did you mean "name"?
//   line 4, column 30: objects[0].physics.behavior of "cup": must be AUTO, STATIC, RIGID or ELASTIC, not
//   "SQUISHY"
// Also refused: wrong types, numbers out of range, repeated fields, two fields of a oneof, and any text that
// is not JSON. The contents of `message` are replaced. They are undefined after an error.
Result<void> parse_json_message(std::string_view text, google::protobuf::Message& message);

}  // namespace livegs
