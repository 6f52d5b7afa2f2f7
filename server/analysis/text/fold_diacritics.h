// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace livegs {

// UTF-8 text with Latin letters that carry marks brought to plain ones ("crème brûlée" to "creme brulee",
// "Straße" to "strasse"), also where the mark is a character of its own, as some file systems write it.
// Everything else stays as it is.
std::string fold_diacritics(std::string_view text);

}  // namespace livegs
