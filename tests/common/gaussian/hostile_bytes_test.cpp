// SPDX-License-Identifier: Apache-2.0
// Truncated, damaged and inconsistent files. Every reader returns an asset that meets its invariants or an
// error, and memory stays bounded by the size of the file.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <random>
#include <string>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/gltf/gltf_sample.h"
#include "common/gaussian/shared_data.h"
#include "common/gaussian/synthetic_asset.h"
#include "core/file.h"
#include "gaussian/asset/decompress.h"
#include "gaussian/asset/establish_invariants.h"
#include "gaussian/asset/readers.h"
#include "gaussian/asset_file.h"
#include "gaussian/ply/ply_header.h"
#include "gaussian/sog/sog_files.h"

namespace livegs {
namespace {

using Buffer = std::vector<std::byte>;

Buffer bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// `metric`: without the record that says that the unit is a guess.
Buffer spz_file(int version, int degree, bool metric = true) {
  AssetFrame frame;
  frame.metres_per_unit = metric ? 1 : 0;
  return *encode_spz(synthetic_asset(20, degree, 5), {.version = version}, frame);
}

Buffer ascii_ply() {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 2\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                           "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    text += std::string("property float ") + name + "\n";
  }
  return bytes_of(text +
                  "end_header\n1 2 3 0.1 0.2 0.3 4 -1 -2 -3 1 0 0 0\n4 5 6 0.1 0.2 0.3 4 -1 -2 -3 0 1 0 0\n");
}

// Random words suffice, because all values are valid.
Buffer compressed_ply() {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement chunk 1\n";
  for (const char* bound : {"min", "max"}) {
    for (const char* name : {"x", "y", "z", "scale_x", "scale_y", "scale_z", "r", "g", "b"}) {
      text += std::string("property float ") + bound + "_" + name + "\n";
    }
  }
  text += "element vertex 5\n";
  for (const char* name : {"position", "rotation", "scale", "color"})
    text += std::string("property uint packed_") + name + "\n";
  text += "element sh 5\n";
  for (int i = 0; i < 9; ++i) text += "property uchar f_rest_" + std::to_string(i) + "\n";
  text += "end_header\n";
  Buffer bytes = bytes_of(text);
  const auto add = [&](auto value) {
    const auto* raw = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), raw, raw + sizeof(value));
  };
  for (int i = 0; i < 9; ++i) add(-1.0f);
  for (int i = 0; i < 9; ++i) add(1.0f);
  std::mt19937_64 engine(8);
  for (int i = 0; i < 20; ++i) add(static_cast<uint32_t>(engine()));
  for (int i = 0; i < 45; ++i) add(static_cast<uint8_t>(engine()));
  return bytes;
}

Buffer splat_file() {
  Buffer bytes(32 * 5);
  std::mt19937_64 engine(9);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(engine());
  for (size_t record = 0; record < 5; ++record) {
    const float values[6] = {1, 2, 3, 0.1f, 0.2f, 0.3f};
    std::memcpy(bytes.data() + 32 * record, values, sizeof(values));
  }
  return bytes;
}

struct Sample {
  std::string name;
  Buffer bytes;
};

std::vector<Sample> samples() {
  std::vector<Sample> all = {{"binary.ply", encode_ply(synthetic_asset(4, 1, 5))},
                             {"text.ply", ascii_ply()},
                             {"small.compressed.ply", compressed_ply()},
                             {"small.splat", splat_file()}};
  for (const int version : {2, 3, 4}) {
    all.push_back({"v" + std::to_string(version) + ".spz", spz_file(version, 1)});
    all.push_back({"guess" + std::to_string(version) + ".spz", spz_file(version, 1, false)});
  }
  all.push_back({"written.compressed.ply", *encode_compressed_ply(synthetic_asset(5, 1, 6))});
  all.push_back({"written.sog", *encode_sog(synthetic_asset(6, 1, 6))});
  all.push_back({"small.glb", gltf_sample(synthetic_asset(4, 1, 6)).glb()});
  const GltfSample text = gltf_sample(synthetic_asset(2, 0, 6));
  all.push_back({"small.gltf", text.gltf(text.data_uri())});
  AssetFrame far;
  far.origin = {5e5, 5.4e6, 30};
  all.push_back({"doubles.ply", encode_ply(synthetic_asset(4, 0, 5), far, true)});
  const Result<Buffer> sog = read_file(shared_data() / "fixtures/sog/kit-multi-degree3-deflated.sog");
  if (sog) all.push_back({"small.sog", *sog});
  return all;
}

TEST(HostileBytes, SamplesAreValid) {
  for (const Sample& sample : samples()) {
    const Result<AssetFile> file = decode_asset(sample.bytes, sample.name);
    ASSERT_TRUE(file) << file.error().message;
    expect_invariants(file->asset, sample.name);
  }
}

TEST(HostileBytes, RejectsEveryTruncation) {
  for (const Sample& sample : samples()) {
    for (size_t length = 0; length < sample.bytes.size(); ++length) {
      // The buffer has exactly the readable length, so a sanitizer detects reads past it.
      const Buffer cut(sample.bytes.begin(), sample.bytes.begin() + static_cast<ptrdiff_t>(length));
      const Result<AssetFile> file = decode_asset(cut, sample.name);
      if (sample.name == "small.splat" && length % 32 == 0 && length > 0)
        continue;  // whole records are a valid file
      if (sample.name == "text.ply" && length + 1 == sample.bytes.size())
        continue;  // only the last line break is missing
      ASSERT_FALSE(file) << sample.name << " cut to " << length << " of " << sample.bytes.size()
                         << " bytes was read";
      EXPECT_TRUE(file.error().message.starts_with(sample.name)) << file.error().message;
    }
  }
}

TEST(HostileBytes, RejectsTrailingBytesOfCompressedFormats) {
  for (Sample& sample : samples()) {
    if (!sample.name.ends_with(".spz")) continue;
    sample.bytes.push_back(std::byte{0});
    EXPECT_FALSE(decode_asset(sample.bytes, sample.name)) << sample.name;
  }
}

// Mutates bytes: one to eight bytes replaced, bits flipped, or a range copied over another. Half of the
// mutations are near the start, where headers are.
Buffer mutated(Buffer bytes, std::mt19937_64& engine) {
  const size_t changes = 1 + engine() % 8;
  for (size_t i = 0; i < changes; ++i) {
    const size_t span = engine() % 2 ? bytes.size() : std::min<size_t>(bytes.size(), 64);
    const size_t at = engine() % span;
    switch (engine() % 4) {
      case 0:
        bytes[at] = static_cast<std::byte>(engine());
        break;
      case 1:
        bytes[at] ^= static_cast<std::byte>(1u << engine() % 8);
        break;
      case 2:
        bytes[at] = engine() % 2 ? std::byte{0xff} : std::byte{0};
        break;
      default: {
        const size_t length = std::min<size_t>(1 + engine() % 8, bytes.size() - at);
        const size_t from = engine() % (bytes.size() - length + 1);
        std::memmove(bytes.data() + at, bytes.data() + from, length);
      }
    }
  }
  return bytes;
}

void survives(const Buffer& bytes, const std::string& name) {
  const Result<AssetFile> file = decode_asset(bytes, name);
  if (file) {
    expect_invariants(file->asset, name);
  } else {
    EXPECT_NE(file.error().message.find("; "), std::string::npos) << file.error().message << " has no remedy";
    EXPECT_EQ(file.error().message.find('\n'), std::string::npos) << file.error().message;
  }
}

TEST(HostileBytes, SurvivesMutationsOfEachFormat) {
  for (const Sample& sample : samples()) {
    std::mt19937_64 engine(1);
    for (int i = 0; i < 4000; ++i) survives(mutated(sample.bytes, engine), sample.name);
  }
}

// The checksum of gzip blocks mutations of its content, so these are applied before compression.
TEST(HostileBytes, SurvivesMutationsInsideSpzGzip) {
  for (const int version : {2, 3}) {
    const Buffer file = spz_file(version, 2);
    GunzipStream stream(file, "sample");
    const size_t kernel_bytes = 16 + 3 + (version == 2 ? 0 : 1) + 24;
    const Result<Buffer> inside = stream.take(16 + 20 * kernel_bytes);
    ASSERT_TRUE(inside) << inside.error().message;
    ASSERT_EQ(*stream.drain(), 0u);
    std::mt19937_64 engine(3);
    for (int i = 0; i < 4000; ++i) survives(gzip(mutated(*inside, engine)), "inside.spz");
  }
}

// The same for .sog: its files without the archive.
class FilesInMemory : public SogFiles {
 public:
  explicit FilesInMemory(std::map<std::string, Buffer> files)
      : SogFiles("memory.sog"), files_(std::move(files)) {}
  std::map<std::string, Buffer> files_;

 protected:
  Result<Buffer> read_plain_name(const std::string& file) const override {
    const auto found = files_.find(file);
    if (found == files_.end()) return not_found("memory.sog: has no " + file);
    return found->second;
  }
};

TEST(HostileBytes, SurvivesMutationsOfEachSogFile) {
  LIVEGS_NEEDS_SHARED_DATA();
  std::map<std::string, Buffer> good;
  uint64_t total_bytes = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(shared_data() / "fixtures/sog/unbundled-kit-multi-degree3")) {
    good[entry.path().filename().string()] = *read_file(entry.path());
    total_bytes += entry.file_size();
  }
  ASSERT_TRUE(read_sog(FilesInMemory(good), total_bytes, "memory.sog"));
  std::mt19937_64 engine(4);
  for (const auto& [name, bytes] : good) {
    FilesInMemory files(good);
    for (int i = 0; i < 300; ++i) {
      files.files_[name] = mutated(bytes, engine);
      Result<AssetFile> file = read_sog(files, total_bytes, "memory.sog");
      if (file && establish_invariants(*file, name)) expect_invariants(file->asset, name);
    }
  }
}

TEST(HostileBytes, RejectsDeeplyNestedMeta) {
  for (const char* nest : {"[", "{\"means\":"}) {
    std::string text;
    while (text.size() < 1000000) text += nest;
    EXPECT_FALSE(read_sog(FilesInMemory({{"meta.json", bytes_of(text)}}), text.size(), "nested.sog"));
  }
}

// Version 4 has uncompressed tables.
TEST(HostileBytes, SurvivesMutationsOfSpz4Headers) {
  const Buffer bytes = spz_file(4, 3);
  std::mt19937_64 engine(2);
  for (int i = 0; i < 20000; ++i) {
    Buffer changed = bytes;
    const size_t at = 4 + engine() % 124;  // header and table
    changed[at] = static_cast<std::byte>(engine());
    survives(changed, "v4.spz");
  }
}

long peak_memory_kib() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(HostileBytes, LargeCountsAllocateNoMemory) {
  std::vector<Sample> liars;
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                           "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    header += std::string("property float ") + name + "\n";
  }
  liars.push_back({"huge.ply", bytes_of(header + "end_header\n" + std::string(1000, 'x'))});
  std::string overflow = header;
  overflow.replace(overflow.find("4000000000"), 10, "18446744073709551615");
  liars.push_back({"overflow.ply", bytes_of(overflow + "end_header\n")});
  std::string list =
      "ply\nformat binary_little_endian 1.0\nelement face 1000\nproperty list uint double v\n" +
      header.substr(header.find("element"));
  liars.push_back({"list.ply", bytes_of(list + "end_header\n" + std::string(5000, '\xff'))});
  std::string text = header;
  text.replace(text.find("binary_little_endian"), 20, "ascii");
  liars.push_back({"text.ply", bytes_of(text + "end_header\n1 2 3")});
  std::string chunked =
      "ply\nformat binary_little_endian 1.0\nelement chunk 4000000000\nproperty float min_x\nelement vertex "
      "1\nproperty uint packed_position\nend_header\n";
  liars.push_back({"huge.compressed.ply", bytes_of(chunked)});
  for (const uint32_t count : {200000u, 0x7fffffffu, 0xffffffffu}) {
    Buffer v4 = spz_file(4, 3);
    std::memcpy(v4.data() + 8, &count, sizeof(count));
    liars.push_back({"huge.spz", v4});
  }
  const long before = peak_memory_kib();
  for (const Sample& liar : liars) EXPECT_FALSE(decode_asset(liar.bytes, liar.name)) << liar.name;
  // The largest claim that is not rejected outright is 1032 times a file of 5 kB.
  EXPECT_LT(peak_memory_kib() - before, 32 * 1024);
}

}  // namespace
}  // namespace livegs
