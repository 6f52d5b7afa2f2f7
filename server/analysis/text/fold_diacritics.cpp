// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/text/fold_diacritics.h"

#include <array>

namespace livegs {
namespace {

// Letters of U+00C0 to U+017F (Latin-1 Supplement and Latin Extended-A), in order. A dot marks a code point
// that is not a letter.
constexpr std::string_view kLatin =
    "A A A A A A AE C E E E E I I I I D N O O O O O . O U U U U Y Th ss "
    "a a a a a a ae c e e e e i i i i d n o o o o o . o u u u u y th y "
    "A a A a A a C c C c C c C c D d D d E e E e E e E e E e G g G g "
    "G g G g H h H h I i I i I i I i I i IJ ij J j K k k L l L l L l L "
    "l L l N n N n N n n N n O o O o O o OE oe R r R r R r S s S s S s "
    "S s T t T t T t U u U u U u U u U u U u W w Y y Y Z z Z z Z z s ";
constexpr char32_t kFirst = 0xC0, kLast = 0x17F;

std::array<std::string_view, kLast - kFirst + 1> latin_letters() {
  std::array<std::string_view, kLast - kFirst + 1> letters;
  size_t begin = 0;
  for (std::string_view& letter : letters) {
    const size_t end = kLatin.find(' ', begin);
    letter = kLatin.substr(begin, end - begin);
    begin = end + 1;
  }
  return letters;
}

}  // namespace

std::string fold_diacritics(std::string_view text) {
  static const auto kLetters = latin_letters();
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0u;
    if (lead < 0xC3 || lead > 0xCD || (next & 0xC0) != 0x80) {  // not a two-byte character of U+00C0 or above
      plain += text[i];
      continue;
    }
    const char32_t character = (lead & 0x1Fu) << 6 | (next & 0x3Fu);
    const bool mark = character >= 0x300 && character <= 0x36F;
    if (character >= kFirst && character <= kLast) {
      plain += kLetters[character - kFirst];
    } else if (!mark) {
      plain += text.substr(i, 2);
    }
    ++i;
  }
  return plain;
}

}  // namespace livegs
