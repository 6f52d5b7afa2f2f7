// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace livegs {

// A QR code for a terminal, in lines of half blocks, dark on light; empty if `text` is too long. Any thread.
std::string qr_text(const std::string& text);

}  // namespace livegs
