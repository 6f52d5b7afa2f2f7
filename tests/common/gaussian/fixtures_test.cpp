// SPDX-License-Identifier: Apache-2.0
// Reads every small file of shared/data/fixtures, valid and invalid. The file name states the defect.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/gaussian/shared_data.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

// Expected content of a valid file.
struct Good {
  size_t count;
  int sh_degree;
  AssetFormat format;
  int version = 0;
};

const std::map<std::string, Good> kGood = {
    {"ply/degree-1-sh.ply", {1, 1, AssetFormat::Ply}},
    {"ply/degree-2-sh.ply", {1, 2, AssetFormat::Ply}},
    {"ply/degree-3-sh.ply", {1, 3, AssetFormat::Ply}},
    {"ply/one-gaussian-ascii.ply", {1, 0, AssetFormat::Ply}},
    {"ply/one-gaussian-binary-le.ply", {1, 0, AssetFormat::Ply}},
    {"ply/reordered-properties.ply", {1, 1, AssetFormat::Ply}},
    {"ply/three-gaussian-binary-le.ply", {3, 1, AssetFormat::Ply}},
    {"misc/3-points-from-train.ply", {3, 3, AssetFormat::Ply}},
    {"misc/train-1000_inria.ply", {1000, 3, AssetFormat::Ply}},
    {"misc/3-points-from-train.splat", {3, 0, AssetFormat::Splat}},
    {"misc/minimal.splat", {4, 0, AssetFormat::Splat}},
    {"misc/3-points-from-train.spz", {3, 3, AssetFormat::Spz, 3}},
    {"misc/minimal-v2.spz", {4, 0, AssetFormat::Spz, 2}},
    {"misc/minimal-v3.spz", {4, 0, AssetFormat::Spz, 3}},
    {"misc/minimal-v4.spz", {4, 0, AssetFormat::Spz, 4}},
    {"equivalence/equiv-degree1-offgrid-binary-le.ply", {3, 1, AssetFormat::Ply}},
    {"equivalence/equiv-degree1-offgrid-v2.spz", {3, 1, AssetFormat::Spz, 2}},
    {"equivalence/equiv-degree1-offgrid.sog", {3, 1, AssetFormat::Sog, 2}},
    {"equivalence/equiv-degree3-exact-binary-le.ply", {4, 3, AssetFormat::Ply}},
    {"equivalence/equiv-degree3-exact-v2.spz", {4, 3, AssetFormat::Spz, 2}},
    {"equivalence/equiv-degree3-exact-v3.spz", {4, 3, AssetFormat::Spz, 3}},
    {"equivalence/equiv-degree3-exact.sog", {4, 3, AssetFormat::Sog, 2}},
    {"spz/minimal-v1.spz", {1, 0, AssetFormat::Spz, 1}},
    {"spz/minimal-v2.spz", {1, 0, AssetFormat::Spz, 2}},
    {"spz/minimal-v3.spz", {1, 0, AssetFormat::Spz, 3}},
    {"spz/decode-v1.spz", {1, 0, AssetFormat::Spz, 1}},
    {"spz/decode-v3.spz", {1, 0, AssetFormat::Spz, 3}},
    {"spz/decode-degree1-v2.spz", {2, 1, AssetFormat::Spz, 2}},
    {"spz/decode-degree3-v2.spz", {2, 3, AssetFormat::Spz, 2}},
    {"spz/decode-degree4-v2.spz", {1, 3, AssetFormat::Spz, 2}},  // cut to degree 3, with a note
    {"spz/degree3-v2.spz", {1, 3, AssetFormat::Spz, 2}},
    {"spz/degree4-v2.spz", {1, 3, AssetFormat::Spz, 2}},
    {"spz/extensions-v2.spz", {1, 0, AssetFormat::Spz, 2}},
    {"spz/header-fields-v2.spz", {1, 0, AssetFormat::Spz, 2}},  // of the gzip header
    {"spz/long-fname-v2.spz", {1, 0, AssetFormat::Spz, 2}},
    {"spz/three-points-degree1-v2.spz", {3, 1, AssetFormat::Spz, 2}},
    {"sog/decode-degree1.sog", {2, 1, AssetFormat::Sog, 2}},
    {"sog/kit-one-degree0.sog", {1, 0, AssetFormat::Sog, 2}},
    {"sog/kit-multi-degree3.sog", {3, 3, AssetFormat::Sog, 2}},
    {"sog/kit-multi-degree3-deflated.sog", {3, 3, AssetFormat::Sog, 2}},
    {"sog/unbundled-kit-multi-degree3", {3, 3, AssetFormat::Sog, 2}},
    {"sog/unbundled-kit-multi-degree3/meta.json", {3, 3, AssetFormat::Sog, 2}},
};

// Substring of the error of each invalid file.
const std::map<std::string, std::string> kBad = {
    {"ply/degree-4-sh.ply", "degree 4"},
    {"ply/duplicate-sh-index.ply", "f_rest_00"},
    {"ply/empty-vertex.ply", "no rows"},
    {"ply/invalid-sh-name.ply", "f_rest_1x"},
    {"ply/list-property.ply", "a list as property opacity"},
    {"ply/mesh-not-gaussian.ply", "give a Gaussian splat file"},
    {"ply/missing-opacity.ply", "no property opacity"},
    {"ply/nan-opacity-binary-le.ply", "finite"},
    {"ply/non-contiguous-sh.ply", "f_rest_2 is missing"},
    {"ply/out-of-range-double.ply", "finite"},
    {"ply/overflow-scale.ply", "finite"},
    {"ply/sh-count-not-rgb.ply", "2 f_rest"},
    {"ply/sh-invalid-degree.ply", "6 f_rest"},
    {"ply/truncated-binary-le.ply", "more than the file can hold"},
    {"misc/minimal-raw.spz", "must be compressed"},
    {"misc/minimal.ksplat", "unknown format"},
    {"spz/bad-crc-v2.spz", "incorrect data check"},
    {"spz/bad-fhcrc-v2.spz", "header crc"},
    {"spz/bad-isize-v2.spz", "incorrect length check"},
    {"spz/corrupt-deflate.spz", "damaged"},
    {"spz/count-exceeds-stream-v2.spz", "1000000 kernels, more than"},
    {"spz/decode-nonfinite-v1.spz", "finite"},
    {"spz/empty-points-v2.spz", "no kernels"},
    {"spz/gzip-not-spz.spz", "does not contain an .spz"},
    {"spz/huge-count-v2.spz", "2147483648 kernels, more than"},
    {"spz/not-spz.spz", "unknown format"},
    {"spz/plaintext-v2.spz", "must be compressed"},
    {"spz/plaintext-v4.spz", "streams"},
    {"spz/sh-degree-5-v2.spz", "SH degree 5"},
    {"spz/short-stream.spz", "before the size in its header"},
    {"spz/trailing-after-member-v2.spz", "8 bytes follow"},
    {"spz/trailing-decompressed-v2.spz", "6 bytes follow"},
    {"spz/truncated-deflate-v2.spz", "truncated"},
    {"spz/truncated-gzip-header.spz", "truncated"},
    {"spz/truncated-payload-v2.spz", "before the size in its header"},
    {"spz/version-0.spz", "version 0"},
    {"spz/version-5.spz", "version 5"},
    {"sog/bad-bands.sog", "bands"},
    {"sog/bad-quat-tag.sog", "outside 252 to 255"},
    {"sog/bad-zip.sog", "zip archive"},
    {"sog/corrupt-plane.sog", "scales.webp"},
    {"sog/count-exceeds-plane.sog", "too few for 4096 kernels"},
    {"sog/device-plane-name.sog", "no file NUL.webp"},
    {"sog/empty-count.sog", "count"},
    {"sog/escaping-plane-name.sog", "not a plain file name"},
    {"sog/huge-bands.sog", "bands"},
    {"sog/huge-count.sog", "count"},
    {"sog/huge-palette-count.sog", "count"},
    {"sog/huge-version.sog", "version 1e+300"},
    {"sog/labels-out-of-range.sog", "palette of 1"},
    {"sog/lossy-plane.sog", "lossless"},
    {"sog/malformed-meta.sog", "JSON"},
    {"sog/missing-plane.sog", "no file scales.webp"},
    {"sog/no-meta.sog", "no file meta.json"},
    {"sog/not-sog.json", "give a splat file, or the meta.json"},
    {"sog/not-sog.sog", "unknown format"},
    {"sog/short-codebook.sog", "256 numbers"},
    {"sog/unbundled-missing-plane", "sh0.webp"},
    {"sog/version-1.sog", "version 1"},  // no version, and not the layout of version 1
    {"sog/version-3.sog", "version 3"},
};

TEST(Fixtures, ValidFilesAreRead) {
  LIVEGS_NEEDS_SHARED_DATA();
  for (const auto& [name, good] : kGood) {
    const Result<AssetFile> file = read_asset(shared_data() / "fixtures" / name);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->asset.size(), good.count) << name;
    EXPECT_EQ(file->asset.sh_degree, good.sh_degree) << name;
    EXPECT_STREQ(format_name(file->format), format_name(good.format)) << name;
    EXPECT_EQ(file->format_version, good.version) << name;
    EXPECT_EQ(file->y_up_in_file, good.format == AssetFormat::Spz) << name;
    EXPECT_EQ(file->asset.sh_rest.size(), good.count * file->asset.sh_rest_count()) << name;
  }
}

TEST(Fixtures, InvalidFilesGiveOneLineErrors) {
  LIVEGS_NEEDS_SHARED_DATA();
  for (const auto& [name, words] : kBad) {
    const Result<AssetFile> file = read_asset(shared_data() / "fixtures" / name);
    ASSERT_FALSE(file) << name << " was read";
    const std::string& message = file.error().message;
    EXPECT_NE(message.find(words), std::string::npos) << name << ": " << message;
    EXPECT_NE(message.find(std::filesystem::path(name).filename().string()), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find("; "), std::string::npos) << message << " has no remedy";
  }
}

TEST(Fixtures, AllFilesAreCovered) {
  LIVEGS_NEEDS_SHARED_DATA();
  const std::filesystem::path root = shared_data() / "fixtures";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    const std::string name = entry.path().lexically_relative(root).generic_string();
    if (entry.is_directory() || name.find("unbundled") != name.npos) continue;
    EXPECT_TRUE(kGood.count(name) + kBad.count(name) == 1) << name;
  }
}

TEST(Fixtures, DegreeFourIsCutWithANote) {
  LIVEGS_NEEDS_SHARED_DATA();
  const Result<AssetFile> file = read_asset(shared_data() / "fixtures/spz/decode-degree4-v2.spz");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->notes.size(), 1u);
  EXPECT_NE(file->notes[0].find("degree 4 to 3"), std::string::npos);
}

TEST(Fixtures, ExtensionsDoNotHideTheAntialiasedFlag) {
  LIVEGS_NEEDS_SHARED_DATA();
  const Result<AssetFile> file = read_asset(shared_data() / "fixtures/spz/extensions-v2.spz");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->asset.antialiased);
}

}  // namespace
}  // namespace livegs
