// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace livegs {

// Replaces Latin letters with diacritics in UTF-8 text by plain letters: "crème brûlée" becomes "creme
// brulee", "Straße" becomes "strasse". Combining marks, which some file systems write, are removed. Other
// text is unchanged.
std::string fold_diacritics(std::string_view text);

}  // namespace livegs
