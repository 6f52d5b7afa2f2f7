// SPDX-License-Identifier: Apache-2.0
#include "viewer/output/write_pictures.h"

#include <algorithm>

#include "core/file.h"
#include "core/log.h"
#include "core/written_files.h"
#include "splat/image.h"
#include "wire/frame_codec.h"

namespace livegs {

Result<void> write_first_picture(const Image& picture, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "first.png";
  auto written = write_png(file, picture);
  if (!written) return written;
  note_written(file);
  log_info("first picture: %s", file.c_str());
  return {};
}

Result<void> write_last_picture(const Player& player, const std::filesystem::path& folder) {
  if (player.last_picture()) {
    if (auto written = write_png(folder / "last.png", *player.last_picture()); !written) return written;
    note_written(folder / "last.png");
    const std::vector<ObjectDrivers>& objects = player.last_frame()->objects;
    if (std::any_of(objects.begin(), objects.end(),
                    [](const ObjectDrivers& one) { return one.kernels != nullptr; }))
      return {};
    if (auto written = write_file_atomically(folder / "last_frame.bin", encode_frame(*player.last_frame()));
        !written)
      return written;
    note_written(folder / "last_frame.bin");
  }
  return {};
}

}  // namespace livegs
