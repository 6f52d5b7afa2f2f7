// SPDX-License-Identifier: Apache-2.0
// .spz (Niantic). Versions 1 to 3: header and planes in one gzip member. Version 4: an uncompressed header, a
// table of sizes, then one zstd frame per plane.
#include <algorithm>

#include "gaussian/asset/decompress.h"
#include "gaussian/asset/readers.h"
#include "gaussian/asset/y_up.h"
#include "gaussian/spz/spz_extensions.h"
#include "gaussian/spz/spz_planes.h"

namespace livegs {
namespace {

constexpr size_t kHeader4Bytes = 32;
constexpr size_t kStreamEntryBytes = 16;  // u64 compressed size, u64 size
constexpr int kPositionBits = 24;

Result<void> check_header(const SpzHeader& header, size_t file_bytes, std::string_view name) {
  const std::string prefix = std::string(name) + ": ";
  if (header.count == 0) return invalid_data(prefix + "the header declares no kernels");
  if (header.sh_degree > kSpzMaxShDegree) {
    return invalid_data(prefix + "SH degree " + std::to_string(header.sh_degree) +
                        " is not supported; export it with degree 4 or less");
  }
  if (header.fractional_bits > kPositionBits) {
    return invalid_data(prefix + "has positions with " + std::to_string(header.fractional_bits) +
                        " fractional bits, more than 24; export it again");
  }
  uint64_t width = 0;
  for (const uint64_t plane : spz_plane_widths(header)) width += plane;
  if (width * header.count > kMaxCompressionRatio * file_bytes) {
    return invalid_data(prefix + "claims " + std::to_string(header.count) + " kernels, more than a file of " +
                        std::to_string(file_bytes) + " bytes can hold");
  }
  return {};
}

AssetFile unpacked(const SpzHeader& header, const std::array<Bytes, kSpzPlaneCount>& planes,
                   Bytes extensions) {
  AssetFile file;
  file.asset = unpack_spz(header, planes);
  turn_half_about_x(file.asset);
  file.format = AssetFormat::Spz;
  file.format_version = static_cast<int>(header.version);
  file.y_up_in_file = true;
  file.frame.metres_per_unit = 1;
  file.frame.unit_of_format = true;
  if (header.flags & kSpzHasExtensions) read_spz_frame(extensions, file.frame, file.notes);
  file.frame.up_axis = "-y";  // after the turn; the format has one frame
  if (header.sh_degree > 3)
    file.notes.push_back("cut spherical harmonics of degree " + std::to_string(header.sh_degree) + " to 3");
  return file;
}

Result<AssetFile> read_gzipped(Bytes bytes, std::string_view name) {
  const std::string prefix = std::string(name) + ": ";
  GunzipStream stream(bytes, name);
  const Result<std::vector<std::byte>> start = stream.take(sizeof(SpzHeader));
  if (!start) return start.error();
  const auto header = load<SpzHeader>(*start, 0);
  if (header.magic != kSpzMagic) return invalid_data(prefix + "is a gzip file, but does not contain an .spz");
  if (header.version < 1 || header.version > 3) {
    return unsupported(prefix + "spz version " + std::to_string(header.version) +
                       " is not supported; export it as version 1 to 4");
  }
  const Result<void> checked = check_header(header, bytes.size(), name);
  if (!checked) return checked.error();

  const std::array<uint64_t, kSpzPlaneCount> widths = spz_plane_widths(header);
  std::array<std::vector<std::byte>, kSpzPlaneCount> storage;
  std::array<Bytes, kSpzPlaneCount> planes;
  for (size_t p = 0; p < kSpzPlaneCount; ++p) {
    Result<std::vector<std::byte>> plane = stream.take(widths[p] * header.count);
    if (!plane) return plane.error();
    storage[p] = std::move(*plane);
    planes[p] = storage[p];
  }
  std::vector<std::byte> extensions;
  const Result<size_t> left = stream.drain(&extensions, kMaxSpzExtensionBytes);
  if (!left) return left.error();
  if (*left != 0 && !(header.flags & kSpzHasExtensions)) {
    return invalid_data(prefix + std::to_string(*left) + " bytes follow the kernels");
  }
  return unpacked(header, planes, extensions);
}

Result<AssetFile> read_streams(Bytes bytes, std::string_view name) {
  const std::string prefix = std::string(name) + ": ";
  if (bytes.size() < sizeof(SpzHeader)) return invalid_data(prefix + "ends within the spz header");
  const auto header = load<SpzHeader>(bytes, 0);
  if (header.version >= 1 && header.version <= 3) {
    return invalid_data(prefix + "spz version " + std::to_string(header.version) +
                        " must be compressed with gzip");
  }
  if (header.version != 4)
    return unsupported(prefix + "spz version " + std::to_string(header.version) +
                       " is not supported; export it as version 1 to 4");
  if (bytes.size() < kHeader4Bytes) return invalid_data(prefix + "ends within the spz header");
  const Result<void> checked = check_header(header, bytes.size(), name);
  if (!checked) return checked.error();

  const std::array<uint64_t, kSpzPlaneCount> widths = spz_plane_widths(header);
  const size_t needed = header.sh_degree == 0 ? kSpzPlaneCount - 1 : kSpzPlaneCount;
  const size_t stream_count = header.reserved;
  const size_t table = load<uint32_t>(bytes, sizeof(SpzHeader));
  if (stream_count != needed) {
    return invalid_data(prefix + "has " + std::to_string(stream_count) + " streams instead of the " +
                        std::to_string(needed) + " of SH degree " + std::to_string(header.sh_degree) +
                        "; export it again");
  }
  if (table < kHeader4Bytes || table > bytes.size() ||
      (bytes.size() - table) / kStreamEntryBytes < stream_count) {
    return invalid_data(prefix + "the table of streams lies outside the file");
  }
  size_t at = table + stream_count * kStreamEntryBytes;
  std::array<std::vector<std::byte>, kSpzPlaneCount> storage;
  std::array<Bytes, kSpzPlaneCount> planes;
  for (size_t p = 0; p < stream_count; ++p) {
    const auto compressed = load<uint64_t>(bytes, table + p * kStreamEntryBytes);
    const auto size = load<uint64_t>(bytes, table + p * kStreamEntryBytes + 8);
    if (size != widths[p] * header.count) {
      return invalid_data(prefix + "stream " + std::to_string(p) + " has " + std::to_string(size) +
                          " bytes instead of " + std::to_string(widths[p] * header.count) +
                          "; export it again");
    }
    if (compressed > bytes.size() - at)
      return invalid_data(prefix + "is truncated within stream " + std::to_string(p));
    Result<std::vector<std::byte>> plane = zstd_decompress(bytes.subspan(at, compressed), size, name);
    if (!plane) return plane.error();
    storage[p] = std::move(*plane);
    planes[p] = storage[p];
    at += compressed;
  }
  if (at != bytes.size())
    return invalid_data(prefix + std::to_string(bytes.size() - at) + " bytes follow the last stream");
  const size_t extension_bytes = std::min(table - kHeader4Bytes, kMaxSpzExtensionBytes);
  return unpacked(header, planes, bytes.subspan(kHeader4Bytes, extension_bytes));
}

}  // namespace

Result<AssetFile> read_spz(Bytes bytes, std::string_view name) {
  const bool in_the_clear = bytes.size() >= 4 && load<uint32_t>(bytes, 0) == kSpzMagic;
  return in_the_clear ? read_streams(bytes, name) : read_gzipped(bytes, name);
}

}  // namespace livegs
