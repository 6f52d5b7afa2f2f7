// SPDX-License-Identifier: Apache-2.0
#include "viewer/write_pictures.h"

#include "core/file.h"
#include "splat/image.h"
#include "wire/frame_codec.h"

namespace livegs {

Result<void> write_pictures(const Player& player, const std::filesystem::path& folder) {
  if (player.first_picture()) {
    if (auto written = write_png(folder / "first.png", *player.first_picture()); !written) return written;
  }
  if (player.last_picture()) {
    if (auto written = write_png(folder / "last.png", *player.last_picture()); !written) return written;
    return write_file_atomically(folder / "last_frame.bin", encode_frame(*player.last_frame()));
  }
  return {};
}

}  // namespace livegs
