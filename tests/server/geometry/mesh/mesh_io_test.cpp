// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/mesh_io.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "server/geometry/mesh/mesh_checks.h"

namespace livegs {
namespace {

class ReadObj : public ::testing::Test {
 protected:
  ReadObj()
      : path_(std::filesystem::temp_directory_path() / ("livegs_obj_" + std::to_string(getpid()) + ".obj")) {}
  ~ReadObj() override { std::filesystem::remove(path_); }
  Result<TriangleMesh> read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_obj(path_);
  }
  std::filesystem::path path_;
};

const char* const kCube =
    "# a cube of quads\r\nmtllib none.mtl\no cube\n"
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1 0.5 0.5 0.5\nv 1 1 1\nv 0 1 1\n"
    "vt 0 0\nvn 0 0 1\ns off\n"
    "f 4 3 2 1\nf 5/1 6/1 7/1 8/1\nf 1/1/1 2/1/1 6//1 5\nf -6 -5 -1 -2\nf 1 5 8 4\nf 2 3 7 6";

TEST_F(ReadObj, QuadsCornersAndNegativeIndices) {
  const auto mesh = read(kCube);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->vertices_m.size(), 8u);
  EXPECT_EQ(mesh->triangles.size(), 12u);
  testing::expect_body(*mesh);
  EXPECT_NEAR(signed_volume_m3(*mesh), 1.0, 1e-15);
}

TEST_F(ReadObj, ErrorsNameFileAndLine) {
  for (const auto& [text, line] : std::initializer_list<std::pair<const char*, const char*>>{
           {"v 0 0\n", "line 1"},
           {"v 0 0 x\n", "line 1"},
           {"v 0 0 nan\n", "line 1"},
           {"\nv 1e400 0 0\n", "line 2"},
           {"v 1e30 0 0\n", "line 1"},
           {"v 0 0 0\nf 1 1 2\n", "line 2"},
           {"v 0 0 0\nf 0 1 1\n", "line 2"},
           {"v 0 0 0\nf -2 1 1\n", "line 2"},
           {"v 0 0 0\nf 1 1\n", "line 2"},
           {"v 0 0 0\nf 99999999999999999999 1 1\n", "line 2"},
           {"v 0 0 0\nf one 1 1\n", "line 2"},
           {"", "no face"},
           {"v 0 0 0\nv 1 0 0\nf 1 2 2\n", "no face"}}) {
    const auto mesh = read(text);
    ASSERT_FALSE(mesh) << text;
    EXPECT_NE(mesh.error().message.find(line), std::string::npos) << mesh.error().message;
    EXPECT_NE(mesh.error().message.find(path_.string()), std::string::npos) << mesh.error().message;
  }
  EXPECT_EQ(read_obj(path_.string() + ".absent").error().code, ErrorCode::NotFound);
}

TEST_F(ReadObj, EveryTruncationIsAMeshOrAnError) {
  const std::string whole = kCube;
  for (size_t length = 0; length <= whole.size(); ++length) {
    const auto mesh = read(whole.substr(0, length));
    if (!mesh) continue;
    for (const auto& triangle : mesh->triangles) {
      for (uint32_t vertex : triangle) EXPECT_LT(vertex, mesh->vertices_m.size());
    }
  }
}

}  // namespace
}  // namespace livegs
