// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <gtest/gtest.h>

#include "core/content_hash.h"

namespace livegs {
namespace {

std::filesystem::path scratch_folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "livegs_file_test_XXXXXX").string();
  return ::mkdtemp(pattern.data());
}

TEST(File, ReadsWhatWasWritten) {
  const auto folder = scratch_folder();
  ASSERT_TRUE(write_file_atomically(folder / "a.txt", "first"));
  ASSERT_TRUE(write_file_atomically(folder / "a.txt", "second"));
  EXPECT_EQ(read_text_file(folder / "a.txt").value(), "second");
  // No temporary file remains.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  std::filesystem::remove_all(folder);
}

TEST(File, ErrorsContainPathAndReason) {
  const auto folder = scratch_folder();
  EXPECT_NE(read_file(folder / "absent").error().message.find("absent: no such file"), std::string::npos);
  EXPECT_NE(read_file(folder).error().message.find("not a regular file"), std::string::npos);
  ASSERT_TRUE(write_file_atomically(folder / "big", "0123456789"));
  EXPECT_EQ(read_file(folder / "big", 9).error().code, ErrorCode::TooLarge);
  EXPECT_EQ(write_file_atomically(folder / "no_such_folder" / "a", "x").error().message,
            (folder / "no_such_folder" / "a").string() +
                ": cannot be written: No such file or directory; check the path");
  EXPECT_EQ(write_file_atomically(folder / "big" / "a", "x").error().message,
            (folder / "big" / "a").string() +
                ": cannot be written: Not a directory; give a path that does not lead through a file");
  const auto full = std::make_error_code(std::errc::no_space_on_device);
  EXPECT_EQ(file_error("a.csv", "cannot be written", full).message,
            "a.csv: cannot be written: No space left on device; free space on its disk");
  EXPECT_EQ(file_error("a.csv", "cannot be written", full).code, ErrorCode::Internal);
  std::filesystem::remove_all(folder);
}

TEST(ContentHash, PiecesHaveTheHashOfTheWhole) {
  const std::string text = "some bytes in three pieces";
  const auto bytes = std::as_bytes(std::span(text));
  ContentHasher hasher;
  for (const auto piece : {bytes.first(7), bytes.subspan(7, 0), bytes.subspan(7)}) hasher.add(piece);
  EXPECT_EQ(hasher.hash(), content_hash(bytes));
}

// FIPS 180-2, appendix B.1.
TEST(ContentHash, IsSha256) {
  const std::string text = "abc";
  EXPECT_EQ(content_hash(std::as_bytes(std::span(text))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace livegs
