// SPDX-License-Identifier: Apache-2.0
#include "gaussian/ply/ply_comments.h"

#include "core/text/path_ending.h"
#include "gaussian/asset/words.h"

namespace livegs {
namespace {

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// The key and the value of "KEY: VALUE", "KEY = VALUE" or "KEY VALUE", one word each; else nothing.
std::optional<std::pair<std::string_view, std::string_view>> key_and_value(std::string_view line) {
  const size_t sign = line.find_first_of(":=");
  std::vector<std::string_view> words;
  if (sign == line.npos) {
    words = words_of(line);
  } else {
    words = words_of(line.substr(0, sign));
    for (const std::string_view word : words_of(line.substr(sign + 1))) words.push_back(word);
  }
  if (words.size() != 2) return std::nullopt;
  return std::pair(words[0], words[1]);
}

}  // namespace

void read_ply_comments(const PlyHeader& header, AssetFile& file) {
  for (const std::string& comment : header.comments) {
    const std::string lower = lower_case(comment);
    if (const auto pair = key_and_value(lower)) {
      const auto [key, value] = *pair;
      if (key == "splatrendermode") file.asset.antialiased = is_one_of(value, {"mip", "antialiased"});
      if (is_one_of(key, {"antialiased", "antialias", "anti_aliased"}))
        file.asset.antialiased = is_one_of(value, {"1", "true", "yes", "on"});
    }
    std::string note = read_frame_line(comment, file.frame);
    if (!note.empty()) file.notes.push_back(std::move(note));
  }
}

}  // namespace livegs
