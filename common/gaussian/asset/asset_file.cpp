// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_file.h"

#include <algorithm>
#include <cctype>

#include "core/file.h"
#include "gaussian/asset/establish_invariants.h"
#include "gaussian/asset/readers.h"
#include "gaussian/ply/ply_header.h"

namespace livegs {
namespace {

std::string lower_case_extension(std::string_view name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

bool begins_with(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

Result<AssetFile> read_any_ply(Bytes bytes, std::string_view name) {
  const Result<PlyHeader> header = parse_ply_header(bytes, name);
  if (!header) return header.error();
  return is_compressed_ply(*header) ? read_compressed_ply(*header, bytes, name)
                                    : read_gaussian_ply(*header, bytes, name);
}

Result<AssetFile> read_by_content(Bytes bytes, std::string_view name) {
  using namespace std::string_view_literals;
  if (begins_with(bytes, "ply\n"sv) || begins_with(bytes, "ply\r\n"sv)) return read_any_ply(bytes, name);
  if (begins_with(bytes, "NGSP"sv) || begins_with(bytes, "\x1f\x8b"sv)) return read_spz(bytes, name);
  if (begins_with(bytes, "PK"sv)) return read_sog_bundle(bytes, name);
  if (lower_case_extension(name) == ".splat") return read_splat(bytes, name);
  return invalid_data(std::string(name) +
                      ": unknown format; use .ply, .compressed.ply, .spz, .sog or .splat");
}

Result<AssetFile> finished(Result<AssetFile> file, std::string_view name) {
  if (!file) return file;
  const Result<void> established = establish_invariants(*file, name);
  if (!established) return established.error();
  return file;
}

}  // namespace

const char* format_name(AssetFormat format) {
  switch (format) {
    case AssetFormat::Ply:
      return "ply";
    case AssetFormat::CompressedPly:
      return "compressed.ply";
    case AssetFormat::Spz:
      return "spz";
    case AssetFormat::Sog:
      return "sog";
    case AssetFormat::Splat:
      return "splat";
  }
  return "unknown";
}

Result<AssetFile> decode_asset(std::span<const std::byte> bytes, std::string_view name) {
  return finished(read_by_content(bytes, name), name);
}

Result<AssetFile> read_asset(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return finished(read_sog_folder(path, path.string()), path.string());
  if (lower_case_extension(path.string()) == ".json") {
    if (path.filename() != "meta.json") {
      return invalid_data(path.string() +
                          ": not an asset; only the meta.json of an unbundled .sog is accepted");
    }
    return finished(read_sog_folder(path.has_parent_path() ? path.parent_path() : ".", path.string()),
                    path.string());
  }
  const Result<std::vector<std::byte>> bytes = read_file(path);
  if (!bytes) return bytes.error();
  return decode_asset(*bytes, path.string());
}

Result<void> write_asset(const std::filesystem::path& path, const GaussianAsset& asset,
                         const SpzOptions& spz) {
  const std::string extension = lower_case_extension(path.string());
  if (asset.size() == 0) return invalid_argument(path.string() + ": cannot write an asset without kernels");
  if (extension == ".spz") {
    const Result<std::vector<std::byte>> bytes = encode_spz(asset, spz);
    if (!bytes) return bytes.error();
    return write_file_atomically(path, *bytes);
  }
  if (extension == ".ply" && !path.string().ends_with(".compressed.ply"))
    return write_file_atomically(path, encode_ply(asset));
  return unsupported(path.string() + ": cannot write this format; use .ply or .spz");
}

}  // namespace livegs
