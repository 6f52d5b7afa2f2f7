// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <google/protobuf/message.h>

#include <string>

namespace livegs {

// The JSON form of a message with the field names of its .proto file.
std::string message_text(const google::protobuf::Message& message);
// Whether `text` is such a form; unknown fields are ignored. Any text is safe: deep nesting is refused.
bool read_message_text(const std::string& text, google::protobuf::Message& message);

}  // namespace livegs
