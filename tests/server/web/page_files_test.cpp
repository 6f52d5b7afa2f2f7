// SPDX-License-Identifier: Apache-2.0
#include "web/page_files.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace livegs {
namespace {

TEST(PageFiles, HaveThePageAndItsCore) {
  for (const char* path : {"/", "/index.html", "/livegs-view.js"})
    EXPECT_NE(find_page_file(path), nullptr) << path;
  std::set<std::string_view> names;
  for (const PageFile& file : page_files()) names.insert(file.name);
  for (const char* name : {"/index.html", "/page.js", "/worker.js", "/binder.js", "/livegs.wasm"})
    EXPECT_TRUE(names.contains(name)) << name;
  EXPECT_EQ(find_page_file("/../main.cpp"), nullptr);
  EXPECT_EQ(find_page_file(""), nullptr);
}

// A name with a hash never means other bytes, so it may be kept for ever; each file names the others by
// theirs.
TEST(PageFiles, AreNamedByTheirContent) {
  size_t entries = 0;
  for (const PageFile& file : page_files()) {
    entries += file.named_by_content() ? 0 : 1;
    if (file.named_by_content()) {
      const std::string hash(file.etag.substr(1, 16));
      EXPECT_NE(file.path.find("." + hash + "."), std::string_view::npos) << file.path;
      EXPECT_EQ(find_page_file(file.name), nullptr) << file.name;
    }
    if (file.path.ends_with(".wasm")) continue;
    const std::string text(file.bytes);
    for (size_t at = text.find("'./"); at != std::string::npos; at = text.find("'./", at + 1)) {
      const std::string named = text.substr(at + 2, text.find('\'', at + 2) - at - 2);
      EXPECT_NE(find_page_file(named), nullptr) << file.path << " names " << named;
    }
  }
  EXPECT_EQ(entries, 2u);  // the page and the module of <livegs-view>
}

// The bar of the first picture: 150 kB over the wire without assets.
TEST(PageFiles, AreSmall) {
  size_t brotli = 0, gzip = 0;
  for (const PageFile& file : page_files()) {
    if (file.name == "/player.js" || file.name == "/livegs-view.js")
      continue;  // of other pages than the live one
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
