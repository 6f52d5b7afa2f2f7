// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/decoded_asset.h"
#include "gaussian/asset_frame.h"
#include "gaussian/gaussian_asset.h"
#include "gaussian/read_options.h"

// The Gaussian splat file formats that are read and written. All functions may be called from any thread.
//
// Readers repair values that violate the invariants of GaussianAsset:
//   - A kernel with a NaN, an infinite position, a position over 1e18 (its square overflows) or a standard
//     deviation over e^43 is dropped, with a note. A file without remaining kernels is rejected.
//   - Opacities of exactly 0 and 1 (logits of -inf and +inf) become logits of -16 and +16, which is within
//     one float rounding step.
//   - Standard deviations below e^-43 become e^-43, because their squares are not normal floats. Zero is
//     usual in .splat.
//   - Quaternions are normalised unless they are unit already. A zero quaternion becomes the identity, with
//     a note.
//   - Spherical harmonics of degree 4 (defined by .spz) are cut to degree 3, with a note.
//   - Assets far from zero are moved there, with a note: subtract_origin.h.
//
// Readers reject counts and sizes that do not agree with the available bytes, wrong checksums, bytes after
// the end of a compressed stream, and files without kernels.
//
// Memory is bounded by the size of the file: a decoded stream is at most kMaxCompressionRatio times as long.

namespace livegs {

const char* format_name(AssetFormat format);  // "ply", "compressed.ply", "spz", "sog", "splat", "glTF"

// Reads a file or, for an unbundled or streamed .sog, its folder or the meta.json or lod-meta.json in it; of
// a streamed one, the finest level. The format is detected by content first, then by extension.
Result<AssetFile> read_asset(const std::filesystem::path& path, const ReadOptions& options = {});

// Decodes the bytes of a single-file format. `name` is the name of the file in errors. Its extension matters
// only for .splat, which has no magic number.
Result<AssetFile> decode_asset(std::span<const std::byte> bytes, std::string_view name,
                               const ReadOptions& options = {});

// Returns the axes and the unit that a file states. Only the head of a .ply is read; other files are read
// whole. The result has no origin. It is empty if the file cannot be read.
AssetFrame named_frame(const std::filesystem::path& path);

struct SpzOptions {
  int version = 3;           // 2, 3 (gzip) or 4 (zstd)
  int fractional_bits = 12;  // of a position; fewer are used if the extent of the asset does not fit 24 bits
  int sh1_bits = 5;          // bits kept of the eight of each coefficient of degree 1; 8 keeps all
  int sh_rest_bits = 4;      // bits kept for degrees 2 and 3; the default is that of other writers
};

// The writers store the frame as asset_frame.h describes: .ply and .compressed.ply as comments, .sog as
// member "livegs" of meta.json, .spz as extension record 0x4c560001, .glb as asset.extras.livegs. .splat
// stores none.

// Writes binary little-endian .ply in the INRIA property order, normals zero. Decoding returns the same bits.
// The server sends this form to clients. `with_origin` adds the frame's origin to the positions and writes
// them as doubles; decoding subtracts it again.
std::vector<std::byte> encode_ply(const GaussianAsset& asset, const AssetFrame& frame = {},
                                  bool with_origin = false);

// Quantises and rotates to the y-up frame of .spz. Worst-case errors with the default options:
//   positions          2^-13
//   log-scales         1/32 within [-10, 5.94]
//   opacity            1/510
//   sh_dc              0.0131 within +-3.33
//   SH of degree 1     4.5/128; of higher degrees 8.5/128, within +-1
//   rotations          0.28 degrees
// Version 2 does not store the fourth quaternion component: 0.7 degrees typically, up to 7 for half turns.
Result<std::vector<std::byte>> encode_spz(const GaussianAsset& asset, const SpzOptions& options = {},
                                          const AssetFrame& frame = {});

// Quantises in chunks of 256 neighbours, in Morton order. Worst-case errors, where `side` is the range of a
// value within its chunk:
//   positions, log-scales   side/2046 (y), side/4094 (x, z); log-scales within +-20
//   opacity                 1/510
//   sh_dc                   side/510
//   other SH                1/64; 3/128 beyond +-3.95; within +-4
//   rotations               0.28 degrees
Result<std::vector<std::byte>> encode_compressed_ply(const GaussianAsset& asset,
                                                     const AssetFrame& frame = {});

// Quantises to a bundled .sog of version 2, in Morton order. Worst-case errors, where `range` is that of all
// values:
//   positions      range/131070 of sign(x) ln(1 + |x|)
//   log-scales     range/128, sh_dc range/128; typically a tenth of that (tables of 256 values)
//   opacity        1/510
//   other SH       range/128 up to 65,536 kernels; larger assets share 65,536 palette entries
//   rotations      1.1 degrees
Result<std::vector<std::byte>> encode_sog(const GaussianAsset& asset, const AssetFrame& frame = {});

// Writes a .glb with KHR_gaussian_splatting, in floats. Values are exact to their rounding; opacities within
// 6e-8 of 1 become 1.
Result<std::vector<std::byte>> encode_glb(const GaussianAsset& asset, const AssetFrame& frame = {});

// Writes 32-byte records in descending order of opacity times volume. Positions and deviations are exact to a
// float; worst-case errors: opacity 1/510, sh_dc 0.007 within +-1.77, rotations 1.1 degrees. Harmonics of
// degree 1 and up are left out.
Result<std::vector<std::byte>> encode_splat(const GaussianAsset& asset);

struct WriteOptions {
  SpzOptions spz;
  bool with_origin = false;  // .ply: see encode_ply
};

inline constexpr const char* kWrittenEndings[] = {".ply", ".compressed.ply", ".spz",
                                                  ".sog", ".splat",          ".glb"};

// Selects the format by extension, in any letter case: one of kWrittenEndings. Replaces the file atomically.
Result<void> write_asset(const std::filesystem::path& path, const GaussianAsset& asset,
                         const AssetFrame& frame = {}, const WriteOptions& options = {});

// Properties that the format of the file `name` cannot store, one line each.
std::vector<std::string> losses_of_format(std::string_view name, const GaussianAsset& asset,
                                          const AssetFrame& frame, const WriteOptions& options = {});

}  // namespace livegs
