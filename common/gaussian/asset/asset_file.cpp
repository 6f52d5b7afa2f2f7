// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_file.h"

#include <algorithm>
#include <fstream>

#include "core/file.h"
#include "core/text/path_ending.h"
#include "gaussian/asset/establish_invariants.h"
#include "gaussian/asset/readers.h"
#include "gaussian/asset/subtract_origin.h"
#include "gaussian/asset_name.h"
#include "gaussian/ply/ply_header.h"

namespace livegs {
namespace {

constexpr size_t kMaxHeadBytes = size_t{1} << 20;  // of a PLY header

bool begins_with(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

Result<AssetFile> read_any_ply(Bytes bytes, std::string_view name, const ReadOptions& options) {
  const Result<PlyHeader> header = parse_ply_header(bytes, name);
  if (!header) return header.error();
  return is_compressed_ply(*header) ? read_compressed_ply(*header, bytes, name)
                                    : read_gaussian_ply(*header, bytes, name, options);
}

// A text whose first character is that of a JSON object.
bool begins_as_json(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                              std::min<size_t>(bytes.size(), 4096));
  const size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  return first != text.npos && text[first] == '{';
}

Result<AssetFile> read_by_content(Bytes bytes, const std::filesystem::path& folder, std::string_view name,
                                  const ReadOptions& options) {
  using namespace std::string_view_literals;
  if (begins_with(bytes, "ply\n"sv) || begins_with(bytes, "ply\r\n"sv))
    return read_any_ply(bytes, name, options);
  if (begins_with(bytes, "NGSP"sv) || begins_with(bytes, "\x1f\x8b"sv)) return read_spz(bytes, name);
  if (begins_with(bytes, "PK"sv)) return read_sog_bundle(bytes, name);
  if (begins_with(bytes, "glTF"sv)) return read_gltf(bytes, folder, name);
  // Headerless, so the name decides before the content is taken for a text.
  if (has_ending(name, ".splat")) return read_splat(bytes, name);
  if (begins_as_json(bytes)) return read_gltf(bytes, folder, name);
  return invalid_data(std::string(name) + ": unknown format; use " + kAssetEndings);
}

Result<AssetFile> finished(Result<AssetFile> file, std::string_view name) {
  const auto refuse = [](const Error& error) {
    return error.code == ErrorCode::InvalidData
               ? with_remedy(error, "copy the file again, or export it again")
               : error;
  };
  if (!file) return refuse(file.error());
  const Result<void> established = establish_invariants(*file, name);
  if (!established) return refuse(established.error());
  subtract_origin(*file);
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
    case AssetFormat::Gltf:
      return "glTF";
  }
  return "unknown";
}

Result<AssetFile> decode_asset(std::span<const std::byte> bytes, std::string_view name,
                               const ReadOptions& options) {
  return finished(read_by_content(bytes, {}, name, options), name);
}

Result<AssetFile> read_asset(const std::filesystem::path& path, const ReadOptions& options) {
  std::error_code ignored;
  std::optional<std::filesystem::path> index;
  if (std::filesystem::is_directory(path, ignored)) {
    index = asset_index(path);
    if (!index)
      return not_found(path.string() +
                       ": is a folder without a meta.json or lod-meta.json; give a splat file");
  } else if (is_asset_index(path)) {
    index = path;
  }
  if (index) {
    const bool streamed = lower_case(index->filename().string()) == "lod-meta.json";
    return finished(
        streamed ? read_streamed_sog(*index, path.string()) : read_sog_folder(*index, path.string()),
        path.string());
  }
  if (has_ending(path.string(), ".json")) {
    return invalid_data(
        path.string() +
        ": is not an asset; give a splat file, or the meta.json or lod-meta.json of an unbundled .sog");
  }
  const Result<std::vector<std::byte>> bytes = read_file(path);
  if (!bytes) return bytes.error();
  return finished(
      read_by_content(*bytes, path.has_parent_path() ? path.parent_path() : ".", path.string(), options),
      path.string());
}

AssetFrame named_frame(const std::filesystem::path& path) {
  std::string head;
  std::ifstream file(path, std::ios::binary);
  for (std::string line; head.size() < kMaxHeadBytes && std::getline(file, line);) {
    head += line + "\n";
    if (!head.starts_with("ply") || line.starts_with("end_header")) break;
  }
  if (!head.starts_with("ply")) {
    auto whole = read_asset(path);
    AssetFrame frame = whole ? std::move(whole->frame) : AssetFrame{};
    frame.origin.setZero();
    return frame;
  }
  AssetFrame frame;
  for (size_t at = 0; at < head.size();) {
    const size_t end = std::min(head.find('\n', at), head.size());
    const std::string_view line = std::string_view(head).substr(at, end - at);
    constexpr std::string_view kComment = "comment ";
    if (line.starts_with(kComment)) read_frame_line(line.substr(kComment.size()), frame);
    at = end + 1;
  }
  frame.origin.setZero();
  return frame;
}

Result<void> write_asset(const std::filesystem::path& path, const GaussianAsset& asset,
                         const AssetFrame& frame, const WriteOptions& options) {
  const auto ending = asset_ending(path.string());
  if (asset.size() == 0)
    return invalid_argument(path.string() + ": an asset without kernels cannot be written");
  if (!ending || std::find(std::begin(kWrittenEndings), std::end(kWrittenEndings), *ending) ==
                     std::end(kWrittenEndings)) {
    std::string list;
    for (const char* one : kWrittenEndings) list += (list.empty() ? "" : ", ") + std::string(one);
    return unsupported(path.string() + ": the format cannot be written; use one of " + list);
  }
  const auto write = [&](const Result<std::vector<std::byte>>& bytes) -> Result<void> {
    if (!bytes) return bytes.error();
    return write_file_atomically(path, *bytes);
  };
  if (*ending == ".spz") return write(encode_spz(asset, options.spz, frame));
  if (*ending == ".sog") return write(encode_sog(asset, frame));
  if (*ending == ".splat") return write(encode_splat(asset));
  if (*ending == ".glb") return write(encode_glb(asset, frame));
  if (*ending == ".compressed.ply") return write(encode_compressed_ply(asset, frame));
  return write(encode_ply(asset, frame, options.with_origin));
}

std::vector<std::string> losses_of_format(std::string_view name, const GaussianAsset& asset,
                                          const AssetFrame& frame, const WriteOptions& options) {
  std::vector<std::string> losses;
  const auto ending = asset_ending(name);
  if (!ending) return losses;
  if (options.with_origin && !frame.origin.isZero(0) && *ending != ".ply")
    losses.push_back("the origin is noted, not added: only .ply has positions as doubles");
  if (*ending != ".splat") return losses;
  if (asset.sh_degree > 0)
    losses.push_back("the format has no view-dependent colour: spherical harmonics are left out");
  if (asset.antialiased) losses.push_back("the format has no mark for antialiased training");
  if (!frame_lines(frame, false).empty()) losses.push_back("the format has no axes, unit or origin");
  return losses;
}

}  // namespace livegs
