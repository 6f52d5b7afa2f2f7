// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace livegs {

// Incremental parser of server-sent events (WHATWG HTML, section 9.2). Lines end in CR, LF or CRLF; comments,
// event names and ids are skipped. Its state is bounded by the input.
class SseParser {
 public:
  // Returns the data of each completed event, its lines joined by newlines.
  std::vector<std::string> feed(std::string_view bytes);
  // Returns the last event if the stream ended without the final blank line.
  std::vector<std::string> finish();

 private:
  void end_line(std::vector<std::string>& events);
  std::string line_, data_;
  bool has_data_ = false, after_return_ = false, first_line_ = true;
};

}  // namespace livegs
