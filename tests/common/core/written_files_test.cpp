// SPDX-License-Identifier: Apache-2.0
#include "core/written_files.h"

#include <gtest/gtest.h>

#include "scratch_folder.h"

namespace livegs {
namespace {

TEST(WrittenFiles, NamesFewAndCountsMany) {
  const ScratchFolder folder;
  EXPECT_EQ(written_files_text(), "");
  for (const char* name : {"first.png", "clip.mp4", "last.png", "first.png", "removed.png"})
    note_written(folder.write(name, "x"));
  std::filesystem::remove(folder / "removed.png");
  const std::string at = "written: " + folder.path().string();
  const std::string few = at + "/first.png\n" + at + "/last.png\n" + at + "/clip.mp4\n";
  EXPECT_EQ(written_files_text(), few);
  for (int i = 0; i < 10; ++i)
    note_written(folder.write("shots/window_00" + std::to_string(i) + ".png", "x"));
  note_written(folder.write("shots/notes.txt", "x"));
  EXPECT_EQ(written_files_text(), few + "written: 10 files, " + folder.path().string() +
                                      "/shots/window_000.png to window_009.png\n" + at +
                                      "/shots/notes.txt\n");
}

}  // namespace
}  // namespace livegs
