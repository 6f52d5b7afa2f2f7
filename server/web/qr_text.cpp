// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/qr_text.h"

#include <qrencode.h>

#include <memory>

namespace livegs {
namespace {

constexpr int kQuietZone = 2;  // modules; scanners read it although ISO/IEC 18004 requires 4
constexpr const char* kDarkOnLight = "\x1b[30;107m";
constexpr const char* kPlain = "\x1b[0m";

}  // namespace

std::string qr_text(const std::string& text) {
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeString(text.c_str(), 0, QR_ECLEVEL_L, QR_MODE_8, 1), &QRcode_free);
  if (!code) return "";
  const auto dark = [&](int x, int y) {
    const bool inside = x >= 0 && y >= 0 && x < code->width && y < code->width;
    return inside && (code->data[y * code->width + x] & 1) != 0;
  };
  std::string lines;
  for (int y = -kQuietZone; y < code->width + kQuietZone; y += 2) {
    lines += kDarkOnLight;
    for (int x = -kQuietZone; x < code->width + kQuietZone; ++x) {
      const bool above = dark(x, y), below = dark(x, y + 1);
      lines += above ? (below ? "█" : "▀") : (below ? "▄" : " ");
    }
    lines += kPlain;
    lines += '\n';
  }
  return lines;
}

}  // namespace livegs
