// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace livegs {

// Server-sent events (WHATWG HTML, section 9.2) from bytes that are cut anywhere. Lines end in CR, LF or
// CRLF; comments, event names and ids are passed over. What it keeps between calls is bounded by what it was
// fed.
class SseParser {
 public:
  // The data of each event that `bytes` completed, its lines joined by a newline.
  std::vector<std::string> feed(std::string_view bytes);
  // The last event, where the stream ended without the blank line that should follow it.
  std::vector<std::string> finish();

 private:
  void end_line(std::vector<std::string>& events);
  std::string line_, data_;
  bool has_data_ = false, after_return_ = false, first_line_ = true;
};

}  // namespace livegs
