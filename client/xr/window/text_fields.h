// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

// Fields that panels share. Internal to this room.

namespace livegs {

constexpr size_t kMaxFieldText = 128;  // bytes

// Whether `text` contains `part`, in any case.
bool contains_text(const std::string& text, const std::string& part);
// Whether the text changed. `flags`: ImGuiInputTextFlags; with EnterReturnsTrue, whether Enter was pressed.
bool input_text(const char* id, std::string& text, int flags = 0);

// Fields that report a value once it is finished. Keeps texts while they are typed; the ids of the fields of
// one instance must differ.
class TextFields {
 public:
  // A text that is reported when the user leaves its field or presses Enter.
  std::optional<std::string> text_field(const char* id, const std::string& value);
  // Three numbers over the available width.
  std::optional<std::array<double, 3>> numbers(const char* id, const std::array<double, 3>& values,
                                               const char* format);
  // A list of suggestions with a field on top; the typed text is accepted too.
  std::optional<std::string> choice(const char* id, const std::string& value,
                                    const std::vector<std::string>& suggestions);

 private:
  // By id. Two while a click takes the focus from one field to an earlier one.
  std::map<std::string, std::string> edited_;
  std::string choosing_;
};

}  // namespace livegs
