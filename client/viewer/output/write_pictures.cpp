// SPDX-License-Identifier: Apache-2.0
#include "viewer/output/write_pictures.h"

#include <algorithm>

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
    const std::vector<ObjectDrivers>& objects = player.last_frame()->objects;
    if (std::any_of(objects.begin(), objects.end(),
                    [](const ObjectDrivers& one) { return one.kernels != nullptr; }))
      return {};
    return write_file_atomically(folder / "last_frame.bin", encode_frame(*player.last_frame()));
  }
  return {};
}

}  // namespace livegs
