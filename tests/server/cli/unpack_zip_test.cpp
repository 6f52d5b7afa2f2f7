// SPDX-License-Identifier: Apache-2.0
#include "cli/job/unpack_zip.h"

#include <gtest/gtest.h>
#include <zip.h>

#include <set>
#include <string>
#include <vector>

#include "core/file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

class UnpackZip : public ::testing::Test {
 protected:
  // Packs empty folders (names that end with '/') and files whose bytes are their names.
  Result<fs::path> unpack(const std::vector<std::string>& names) {
    const fs::path packed = folder_ / "photos.zip";
    fs::remove(packed);
    int error = 0;
    zip_t* zip = zip_open(packed.c_str(), ZIP_CREATE, &error);
    for (const std::string& name : names) {
      const auto added =
          name.ends_with('/')
              ? zip_dir_add(zip, name.c_str(), 0)
              : zip_file_add(zip, name.c_str(), zip_source_buffer(zip, name.data(), name.size(), 0), 0);
      EXPECT_GE(added, 0) << name;
    }
    EXPECT_EQ(zip_close(zip), 0);
    fs::remove_all(to_);
    return unpack_zip(packed, to_);
  }
  // Files below the folder, relative to it.
  std::set<std::string> files() const {
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(to_))
      if (entry.is_regular_file()) found.insert(entry.path().lexically_relative(to_));
    return found;
  }
  ScratchFolder folder_;
  const fs::path to_ = folder_ / "unpacked";
};

TEST_F(UnpackZip, GivesTheOnlyTopFolderOrAll) {
  EXPECT_EQ(unpack({"table/", "table/a.jpg", "table/more/b.jpg"}).value(), to_ / "table");
  EXPECT_EQ(read_text_file(to_ / "table/more/b.jpg").value(), "table/more/b.jpg");
  EXPECT_EQ(unpack({"a.jpg", "b.jpg"}).value(), to_);
  EXPECT_EQ(unpack({"table/a.jpg", "chair/b.jpg"}).value(), to_);
  EXPECT_EQ(unpack({"table/a.jpg", "notes.txt"}).value(), to_);
}

// The archive that the Finder makes of a folder.
TEST_F(UnpackZip, SkipsWhatMacosAdds) {
  const auto top = unpack({"table/", "table/a.jpg", "__MACOSX/", "__MACOSX/table/", "__MACOSX/table/._a.jpg",
                           "table/.DS_Store", "table/more/b.jpg", "table/more/.DS_Store", ".DS_Store",
                           "__MACOSX/._table"});
  ASSERT_TRUE(top) << top.error().message;
  EXPECT_EQ(*top, to_ / "table");
  EXPECT_EQ(files(), (std::set<std::string>{"table/a.jpg", "table/more/b.jpg"}));
  EXPECT_NE(unpack({"__MACOSX/._table", ".DS_Store"}).error().message.find("is empty"), std::string::npos);
}

TEST_F(UnpackZip, RefusesNamesOutsideItsFolder) {
  for (const char* name : {"../a.jpg", "table/../../a.jpg", "/a.jpg", "__MACOSX/../../a.jpg"})
    EXPECT_EQ(unpack({"table/b.jpg", name}).error().code, ErrorCode::InvalidData) << name;
  EXPECT_FALSE(fs::exists(folder_ / "a.jpg"));
}

}  // namespace
}  // namespace livegs
