// SPDX-License-Identifier: Apache-2.0
#include "web/page_files.h"

#include <gtest/gtest.h>

#include <string>

namespace livegs {
namespace {

TEST(PageFiles, HaveThePageAndItsCore) {
  for (const char* path : {"/", "/index.html", "/page.js", "/worker.js", "/livegs.wasm"})
    EXPECT_NE(find_page_file(path), nullptr) << path;
  EXPECT_EQ(find_page_file("/../main.cpp"), nullptr);
  EXPECT_EQ(find_page_file(""), nullptr);
}

// The bar of the first picture: 150 kB over the wire without assets.
TEST(PageFiles, AreSmall) {
  size_t brotli = 0, gzip = 0;
  for (const PageFile& file : page_files()) {
    brotli += file.brotli.size();
    gzip += file.gzip.size();
    EXPECT_FALSE(file.bytes.empty()) << file.path;
    EXPECT_LT(file.gzip.size(), file.bytes.size() + 100) << file.path;
  }
  EXPECT_LE(gzip, 150'000u);
  EXPECT_LE(brotli, gzip);
}

// The content security policy allows neither foreign sources nor inline scripts.
TEST(PageFiles, StayOnTheServer) {
  for (const PageFile& file : page_files()) {
    if (file.path.ends_with(".wasm")) continue;
    const std::string text(file.bytes);
    for (const char* word : {"https://", "http://", " onclick=", "eval("})
      EXPECT_EQ(text.find(word), std::string::npos) << file.path << ": " << word;
  }
}

}  // namespace
}  // namespace livegs
