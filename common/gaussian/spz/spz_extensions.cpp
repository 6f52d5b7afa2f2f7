// SPDX-License-Identifier: Apache-2.0
#include "gaussian/spz/spz_extensions.h"

namespace livegs {

std::vector<std::byte> spz_frame_record(const AssetFrame& frame) {
  std::string text;
  for (const std::string& line : y_up_frame_lines(frame)) text += line + "\n";
  std::vector<std::byte> record;
  if (text.empty()) return record;
  append(record, kSpzFrameRecord);
  append(record, static_cast<uint32_t>(text.size()));
  const Bytes bytes = std::as_bytes(std::span(text));
  record.insert(record.end(), bytes.begin(), bytes.end());
  return record;
}

void read_spz_frame(Bytes records, AssetFrame& frame, std::vector<std::string>& notes) {
  while (records.size() >= 8) {
    const auto type = load<uint32_t>(records, 0), length = load<uint32_t>(records, 4);
    records = records.subspan(8);
    if (length > records.size()) return;
    if (type == kSpzFrameRecord) {
      std::string_view text(reinterpret_cast<const char*>(records.data()), length);
      while (!text.empty()) {
        const size_t end = std::min(text.find('\n'), text.size());
        std::string note = read_frame_line(text.substr(0, end), frame);
        if (!note.empty() && notes.size() < 8) notes.push_back(std::move(note));
        text.remove_prefix(std::min(end + 1, text.size()));
      }
    }
    records = records.subspan(length);
  }
}

}  // namespace livegs
