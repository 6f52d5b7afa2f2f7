// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/transcript.h"

namespace livegs {
namespace {

constexpr std::size_t kMaxTextLength = std::size_t{64}
                                       << 10;  // of a server's reply; the rest is marked as cut

std::string cut(std::string_view text) {
  if (text.size() <= kMaxTextLength) return std::string(text);
  return std::string(text.substr(0, kMaxTextLength)) + " [" + std::to_string(text.size() - kMaxTextLength) +
         " bytes cut]";
}

}  // namespace

// Texts are redacted before escaping, since escapes may interrupt the key, and the line is redacted again.
void Transcript::request(std::string_view phase, std::string_view body) {
  OrderedJson parsed = OrderedJson::parse(redact(body), nullptr, false);
  add({{"step", "request"}, {"phase", phase}, {"body", std::move(parsed)}});
}

void Transcript::reply(int status, std::string_view body) {
  add({{"step", "reply"}, {"status", status}, {"body", redact(cut(body))}});
}

void Transcript::tool(std::string_view name, std::string_view arguments, std::string_view result) {
  add({{"step", "tool"},
       {"name", redact(name)},
       {"arguments", redact(cut(arguments))},
       {"result", redact(result)}});
}

void Transcript::note(std::string_view text) { add({{"step", "note"}, {"text", redact(text)}}); }

void Transcript::add(OrderedJson line) {
  lines_ += redact(dump_json(line));
  lines_ += '\n';
}

}  // namespace livegs
