// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/synthetic_asset.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same_bits(const GaussianAsset& a, const GaussianAsset& b) {
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  EXPECT_TRUE(same_bits(a.log_scales, b.log_scales));
  EXPECT_TRUE(same_bits(a.rotations, b.rotations));
  EXPECT_TRUE(same_bits(a.opacity_logits, b.opacity_logits));
  EXPECT_TRUE(same_bits(a.sh_dc, b.sh_dc));
  EXPECT_TRUE(same_bits(a.sh_rest, b.sh_rest));
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_EQ(a.antialiased, b.antialiased);
}

TEST(Ply, RoundTripKeepsEveryBit) {
  for (int degree = 0; degree <= 3; ++degree) {
    GaussianAsset asset = synthetic_asset(257, degree, 1);
    asset.antialiased = degree % 2 == 1;
    const std::vector<std::byte> bytes = encode_ply(asset);
    const Result<AssetFile> file = decode_asset(bytes, "round.ply");
    ASSERT_TRUE(file) << file.error().message;
    expect_same_bits(asset, file->asset);
    EXPECT_TRUE(file->notes.empty());
    EXPECT_EQ(encode_ply(file->asset), bytes);
  }
}

TEST(Ply, WritesTheLayoutOfTheInriaTrainer) {
  const std::vector<std::byte> bytes = encode_ply(synthetic_asset(3, 3, 2));
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_TRUE(text.starts_with("ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"));
  const size_t end = text.find("end_header\n");
  ASSERT_NE(end, text.npos);
  EXPECT_EQ(bytes.size() - end - 11, 3u * 62 * 4);  // 62 floats per kernel at degree 3
}

// One kernel with values that identify their source.
constexpr std::array<const char*, 14> kNames = {"x",      "y",       "z",       "f_dc_0",  "f_dc_1",
                                                "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                                "rot_0",  "rot_1",   "rot_2",   "rot_3"};
constexpr std::array<double, 14> kValues = {1, 2, 3, 4, 5, 6, 7, -1, -2, -3, 0, 1, 0, 0};

void expect_named_values(const Result<AssetFile>& file, const std::string& what) {
  ASSERT_TRUE(file) << what << ": " << file.error().message;
  const GaussianAsset& asset = file->asset;
  ASSERT_EQ(asset.size(), 1u) << what;
  EXPECT_EQ(asset.positions[0], Eigen::Vector3f(1, 2, 3)) << what;
  EXPECT_EQ(asset.sh_dc[0], Eigen::Vector3f(4, 5, 6)) << what;
  EXPECT_EQ(asset.opacity_logits[0], 7) << what;
  EXPECT_EQ(asset.log_scales[0], Eigen::Vector3f(-1, -2, -3)) << what;
  EXPECT_EQ(asset.rotations[0].coeffs(), Eigen::Vector4f(1, 0, 0, 0)) << what;
}

// Converts `value` to `type` in the given byte order.
std::string packed(double value, const std::string& type, bool big_endian) {
  const auto raw = [&](auto typed) {
    std::string bytes(reinterpret_cast<const char*>(&typed), sizeof(typed));
    if (big_endian) std::reverse(bytes.begin(), bytes.end());
    return bytes;
  };
  if (type == "char" || type == "int8") return raw(static_cast<int8_t>(value));
  if (type == "short" || type == "int16") return raw(static_cast<int16_t>(value));
  if (type == "int" || type == "int32") return raw(static_cast<int32_t>(value));
  if (type == "double" || type == "float64") return raw(value);
  return raw(static_cast<float>(value));
}

TEST(Ply, ReadsAnyOrderTypeAndEncoding) {
  const std::array<std::string, 5> types = {"float", "double", "int8", "short", "int32"};
  for (size_t turn = 0; turn < 14; ++turn) {
    for (const std::string encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      std::string header = "ply\nformat " + encoding + " 1.0\ncomment turned by " + std::to_string(turn) +
                           "\nelement vertex 1\n";
      std::string row;
      for (size_t i = 0; i < 14; ++i) {
        const size_t p = (i + turn) % 14;
        const std::string& type = types[(i * 3 + turn) % types.size()];
        header += "property " + type + " " + kNames[p] + "\n";
        row += encoding == "ascii" ? std::to_string(kValues[p]) + " "
                                   : packed(kValues[p], type, encoding == "binary_big_endian");
      }
      expect_named_values(decode_asset(bytes_of(header + "end_header\n" + row), "a.ply"),
                          encoding + std::to_string(turn));
    }
  }
}

TEST(Ply, SkipsOtherElementsAndLists) {
  std::string properties;
  for (const char* name : kNames) properties += std::string("property float ") + name + "\n";
  const std::string elements =
      "element camera 2\nproperty double f\nproperty list uchar short id\nelement vertex 1\n" + properties +
      "property list uint8 float extra\nelement nothing 4000000000\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  std::string text = "ply\r\nformat ascii 1.0\r\n" + elements + "0.5 2 7 8\n0.5 0\n";
  for (const double value : kValues) text += std::to_string(value) + "\n";
  expect_named_values(decode_asset(bytes_of(text + "1 9\n3 0 0 0"), "lists.ply"), "ascii");

  const auto binary = [](double value, const char* type) { return packed(value, type, false); };
  std::string rows = binary(0.5, "double") + binary(2, "char") + binary(7, "short") + binary(8, "short") +
                     binary(0.5, "double") + binary(0, "char");
  for (const double value : kValues) rows += binary(value, "float");
  rows += binary(1, "char") + binary(9, "float") + binary(0, "char");
  expect_named_values(
      decode_asset(bytes_of("ply\nformat binary_little_endian 1.0\n" + elements + rows), "lists.ply"),
      "binary");
}

TEST(Ply, RejectsOverflowingTextNumbers) {
  std::string header = "ply\nformat ascii 1.0\nelement vertex 2\n";
  for (const char* name : kNames) header += std::string("property double ") + name + "\n";
  header += "end_header\n";
  const Result<AssetFile> file = decode_asset(
      bytes_of(header + "1e-999 +2 3 4 5 6 7 -1 -2 -3 1 0 0 0\n1e999 2 3 4 5 6 7 -1 -2 -3 1 0 0 0\n"),
      "huge.ply");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->asset.size(), 1u);
  EXPECT_EQ(file->asset.positions[0], Eigen::Vector3f(0, 2, 3));
  EXPECT_EQ(file->notes.size(), 1u);
}

TEST(Ply, ExtensionSelectsTheWriter) {
  const GaussianAsset asset = synthetic_asset(5, 1, 3);
  const ScratchFolder folder;
  ASSERT_TRUE(write_asset(folder / "a.ply", asset));
  ASSERT_TRUE(write_asset(folder / "a.spz", asset));
  EXPECT_EQ(read_asset(folder / "a.ply")->format, AssetFormat::Ply);
  EXPECT_EQ(read_asset(folder / "a.spz")->format, AssetFormat::Spz);
  // Readers use the content, not the name.
  std::filesystem::rename(folder / "a.spz", folder / "b.ply");
  EXPECT_EQ(read_asset(folder / "b.ply")->format, AssetFormat::Spz);
  for (const auto& [name, format] :
       {std::pair("a.splat", AssetFormat::Splat), std::pair("a.compressed.ply", AssetFormat::CompressedPly),
        std::pair("A.Compressed.PLY", AssetFormat::CompressedPly), std::pair("a.SOG", AssetFormat::Sog),
        std::pair("a.Spz", AssetFormat::Spz), std::pair("a.PLY", AssetFormat::Ply),
        std::pair("a.glb", AssetFormat::Gltf)}) {
    ASSERT_TRUE(write_asset(folder / name, asset)) << name;
    EXPECT_EQ(read_asset(folder / name)->format, format) << name;
  }
  EXPECT_EQ(write_asset(folder / "a.gltf", asset).error().code, ErrorCode::Unsupported);
  EXPECT_EQ(write_asset(folder / "a", asset).error().code, ErrorCode::Unsupported);
  EXPECT_EQ(write_asset(folder / "c.ply", GaussianAsset{}).error().code, ErrorCode::InvalidArgument);
  EXPECT_NE(read_asset(folder / "absent.ply").error().message.find("absent.ply"), std::string::npos);
}

}  // namespace
}  // namespace livegs
