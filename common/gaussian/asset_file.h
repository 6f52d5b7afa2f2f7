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

// Every file format of Gaussian splats that is read or written here. All functions may be called from any
// thread.
//
// What a reader does with values that are off (GaussianAsset states the invariants they must meet):
//   - a kernel with a NaN anywhere, an infinite or absurd position (over 1e18, where squares overflow), or a
//   standard
//     deviation over e^43 is dropped, with a note; a file of which no kernel is left is refused;
//   - opacities of exactly 0 and 1 (logits of -inf and +inf) become logits of -16 and +16, which is less than
//   one
//     rounding step of a float away;
//   - standard deviations below e^-43 (their squares are no normal floats; 0 is usual in .splat) become
//   e^-43;
//   - quaternions are normalised unless they are unit already; one of length zero becomes the identity, with
//   a note;
//   - spherical harmonics of degree 4 (.spz defines them) are cut to degree 3, with a note.
// What a reader refuses: counts and sizes that do not agree with the bytes there are, checksums that do not
// match, bytes behind the end of a compressed stream, a file with no kernels.
//
// Memory is bounded by the size of the file: a decoded stream is at most kMaxCompressionRatio times as long.

namespace livegs {

const char* format_name(AssetFormat format);  // "ply", "compressed.ply", "spz", "sog", "splat"

// A file, or, for an unbundled .sog, its folder or the meta.json in it. The format is found by content first,
// then by extension.
Result<AssetFile> read_asset(const std::filesystem::path& path);

// The same for the bytes of a format that is one file. `name` is what errors call it; its extension matters
// for .splat only, which has nothing else to be known by.
Result<AssetFile> decode_asset(std::span<const std::byte> bytes, std::string_view name);

struct SpzOptions {
  int version = 3;           // 2, 3 (gzip) or 4 (zstd)
  int fractional_bits = 12;  // of a position; fewer are used where the asset is too wide for 24 bits
  int sh1_bits = 5;          // kept of the eight of each coefficient of degree 1 …
  int sh_rest_bits = 4;      // … and of degrees 2 and 3; as other writers do. 8 keeps all.
};

// Binary little-endian .ply in the INRIA order of properties, normals zero. Decoding it gives back the same
// bits (it is what a server sends to its clients).
std::vector<std::byte> encode_ply(const GaussianAsset& asset);

// Quantised, and turned to the y-up frame of .spz. With one step being the worst case: positions 2^-13,
// log-scales 1/32 within [-10, 5.94], opacity 1/510, sh_dc 0.0131 within +-3.33, SH of degree 1 4.5/128 and
// above 8.5/128 within
// +-1, rotations 0.28 degrees (version 2: 0.7 degrees typically; its fourth component is not stored, and half
// turns lose up to 7 degrees).
Result<std::vector<std::byte>> encode_spz(const GaussianAsset& asset, const SpzOptions& options = {});

// By extension: .ply or .spz. Replaces the file atomically.
Result<void> write_asset(const std::filesystem::path& path, const GaussianAsset& asset,
                         const SpzOptions& spz = {});

}  // namespace livegs
