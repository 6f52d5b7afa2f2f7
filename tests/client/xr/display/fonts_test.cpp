// SPDX-License-Identifier: Apache-2.0
#include "xr/display/fonts.h"

#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(Fonts, ArchiveFontIsUsedBeforeTheSystemFont) {
  const ScratchFolder archive;
  const std::filesystem::path program = archive.write("bin/livegs-client", "");
  const std::filesystem::path without = window_font_file(program);
  EXPECT_TRUE(without.empty() || without.is_absolute());
  EXPECT_NE(without.string().find(archive.path().string()), 0u);
  const std::filesystem::path font = archive.write("share/livegs/fonts/DejaVuSans.ttf", "");
  EXPECT_TRUE(std::filesystem::equivalent(window_font_file(program), font));
}

}  // namespace
}  // namespace livegs
