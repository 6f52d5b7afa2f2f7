// SPDX-License-Identifier: Apache-2.0
#include "xr/display/text_layer.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "splat/image.h"

namespace livegs {
namespace {

constexpr std::array<uint8_t, 3> kInk{255, 138, 120};

// Runs of rows with ink: the lines.
std::vector<std::pair<int, int>> lines_of(const TextPlate::Picture& picture) {
  std::vector<std::pair<int, int>> lines;
  bool inside = false;
  for (int y = 0; y < picture.height_px; ++y) {
    bool ink = false;
    for (int x = 0; x < picture.width_px; ++x)
      ink = ink || picture.rgba[4 * (static_cast<size_t>(y) * picture.width_px + x)] > 200;
    if (ink && !inside) lines.emplace_back(y, y);
    if (ink) lines.back().second = y;
    inside = ink;
  }
  return lines;
}

bool is_plate(const TextPlate::Picture& picture, int x, int y) {
  const uint8_t* pixel = &picture.rgba[4 * (static_cast<size_t>(y) * picture.width_px + x)];
  return pixel[0] < 30 && pixel[1] < 30 && pixel[2] < 30 && pixel[3] == 255;
}

TEST(TextPlate, WritesLinesInsideMargins) {
  const TextPlate plate;
  const auto one = plate.draw("MMMM", kInk), two = plate.draw("MMMM\nMMMM", kInk);
  EXPECT_EQ(one.width_px, TextPlate::kWidth_px);
  EXPECT_EQ(lines_of(one).size(), 1u);
  EXPECT_EQ(lines_of(two).size(), 2u);
  EXPECT_GT(two.height_px, one.height_px);
  for (const auto& picture : {one, two}) {
    ASSERT_EQ(picture.rgba.size(), size_t{4} * picture.width_px * picture.height_px);
    for (int x = 0; x < picture.width_px; ++x)
      EXPECT_TRUE(is_plate(picture, x, 0) && is_plate(picture, x, picture.height_px - 1));
    for (int y = 0; y < picture.height_px; ++y)
      EXPECT_TRUE(is_plate(picture, 5, y) && is_plate(picture, picture.width_px - 5, y));
  }
}

TEST(TextPlate, WrapsAndTruncatesText) {
  const TextPlate plate;
  const auto notice = plate.draw("server disconnected: no message for 1 s; reconnecting", kInk);
  EXPECT_EQ(lines_of(notice).size(), 2u);
  if (const char* folder = std::getenv("LIVEGS_TEST_PICTURES")) {
    Image image{notice.width_px, notice.height_px, {}};
    for (const uint8_t value : notice.rgba) image.pixels.push_back(static_cast<float>(value) / 255.0f);
    EXPECT_TRUE(write_png(std::filesystem::path(folder) / "text_plate.png", image));
  }
  const auto word = plate.draw(std::string(500, 'M'), kInk);  // no break opportunity
  EXPECT_LE(word.height_px, TextPlate::kMaxHeight_px);
  for (int y = 0; y < word.height_px; ++y) EXPECT_TRUE(is_plate(word, word.width_px - 5, y));
  EXPECT_LE(plate.draw(std::string(100, '\n') + "end", kInk).height_px, TextPlate::kMaxHeight_px);
}

// Letters do not overlap: columns between those of "ill" have no ink.
TEST(TextPlate, LettersDoNotTouch) {
  const auto picture = TextPlate().draw("ill", kInk);
  int runs = 0;
  bool inside = false;
  for (int x = 0; x < picture.width_px; ++x) {
    bool ink = false;
    for (int y = 0; y < picture.height_px; ++y)
      ink = ink || picture.rgba[4 * (static_cast<size_t>(y) * picture.width_px + x)] > 100;
    runs += ink && !inside;
    inside = ink;
  }
  EXPECT_EQ(runs, 3);
}

// Names may come from untrusted sources.
TEST(TextPlate, AcceptsAnyBytes) {
  const TextPlate plate;
  EXPECT_EQ(lines_of(plate.draw("", kInk)).size(), 0u);
  std::string bytes;
  for (int i = 1; i < 256; ++i) bytes.push_back(static_cast<char>(i));
  for (size_t cut = 0; cut <= bytes.size(); ++cut)
    EXPECT_LE(plate.draw(bytes.substr(cut), kInk).height_px, TextPlate::kMaxHeight_px);
  EXPECT_EQ(lines_of(plate.draw("fa\u00e7ade", kInk)).size(), 1u);
}

}  // namespace
}  // namespace livegs
