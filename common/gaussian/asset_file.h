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
#include "gaussian/gaussian_asset.h"

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
//
// Readers reject counts and sizes that do not agree with the available bytes, wrong checksums, bytes after
// the end of a compressed stream, and files without kernels.
//
// Memory is bounded by the size of the file: a decoded stream is at most kMaxCompressionRatio times as long.

namespace livegs {

const char* format_name(AssetFormat format);  // "ply", "compressed.ply", "spz", "sog", "splat"

// Reads a file or, for an unbundled .sog, its folder or the meta.json in it. The format is detected by
// content first, then by extension.
Result<AssetFile> read_asset(const std::filesystem::path& path);

// Decodes the bytes of a single-file format. `name` is the name of the file in errors. Its extension matters
// only for .splat, which has no magic number.
Result<AssetFile> decode_asset(std::span<const std::byte> bytes, std::string_view name);

struct SpzOptions {
  int version = 3;           // 2, 3 (gzip) or 4 (zstd)
  int fractional_bits = 12;  // of a position; fewer are used if the extent of the asset does not fit 24 bits
  int sh1_bits = 5;          // bits kept of the eight of each coefficient of degree 1; 8 keeps all
  int sh_rest_bits = 4;      // bits kept for degrees 2 and 3; the default is that of other writers
};

// Writes binary little-endian .ply in the INRIA property order, normals zero. Decoding returns the same bits.
// The server sends this form to clients.
std::vector<std::byte> encode_ply(const GaussianAsset& asset);

// Quantises and rotates to the y-up frame of .spz. Worst-case errors with the default options:
//   positions          2^-13
//   log-scales         1/32 within [-10, 5.94]
//   opacity            1/510
//   sh_dc              0.0131 within +-3.33
//   SH of degree 1     4.5/128; of higher degrees 8.5/128, within +-1
//   rotations          0.28 degrees
// Version 2 does not store the fourth quaternion component: 0.7 degrees typically, up to 7 for half turns.
Result<std::vector<std::byte>> encode_spz(const GaussianAsset& asset, const SpzOptions& options = {});

// Selects the format by extension: .ply or .spz. Replaces the file atomically.
Result<void> write_asset(const std::filesystem::path& path, const GaussianAsset& asset,
                         const SpzOptions& spz = {});

}  // namespace livegs
