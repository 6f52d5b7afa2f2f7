// SPDX-License-Identifier: Apache-2.0
// PlayCanvas .compressed.ply. Kernels are stored in chunks of 256 as four 32-bit words each; each value is a
// fraction between the bounds of its chunk. SH of degree 1 and up are in a separate element, one byte per
// coefficient.
#include <optional>

#include "gaussian/asset/readers.h"
#include "gaussian/asset/smallest_three.h"
#include "gaussian/opacity.h"
#include "gaussian/ply/ply_comments.h"
#include "gaussian/ply/ply_header.h"
#include "gaussian/ply/ply_rows.h"

namespace livegs {
namespace {

constexpr size_t kChunk = 256;
constexpr std::array<const char*, 18> kBounds = {
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
constexpr size_t kBoundsWithoutColour = 12;
constexpr std::array<const char*, 4> kWords = {"packed_position", "packed_rotation", "packed_scale",
                                               "packed_color"};

struct ChunkBounds {
  std::array<float, 18> value;
  Eigen::Vector3f lerp(size_t first, const Eigen::Vector3f& t) const {
    const Eigen::Vector3f low(value[first], value[first + 1], value[first + 2]);
    const Eigen::Vector3f high(value[first + 3], value[first + 4], value[first + 5]);
    return low + (high - low).cwiseProduct(t);
  }
};

Eigen::Vector3f unpack_11_10_11(uint32_t word) {
  return {static_cast<float>(word >> 21) / 2047.0f, static_cast<float>((word >> 11) & 1023) / 1023.0f,
          static_cast<float>(word & 2047) / 2047.0f};
}

Eigen::Quaternionf unpack_rotation(uint32_t word) {
  const auto component = [](uint32_t bits) {
    return (static_cast<float>(bits & 1023) / 1023.0f - 0.5f) * 2.0f * kSqrtHalf;
  };
  const Eigen::Vector4f wxyz =
      from_smallest_three(word >> 30, {component(word >> 20), component(word >> 10), component(word)});
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

float unpack_sh(float byte) {
  if (byte == 0) return -4.0f;
  if (byte == 255) return 4.0f;
  return 8.0f * ((byte + 0.5f) / 256.0f - 0.5f);
}

// Columns for the properties `names` of `element`; all must be numbers.
Result<std::vector<PlyColumn>> columns_for(const PlyElement& element, std::span<const char* const> names,
                                           std::string_view file) {
  std::vector<PlyColumn> columns;
  for (const char* property : names) {
    const std::optional<size_t> index = element.find(property);
    if (!index || element.properties[*index].list_count_type) {
      return invalid_data(std::string(file) + ": element " + element.name + " has no property " + property);
    }
    columns.push_back({.property = *index, .stride = names.size()});
  }
  return columns;
}

// SH degree of the element sh; 0 if there is no such element.
Result<int> sh_degree_of(const PlyElement* sh, uint64_t count, std::string_view name) {
  if (!sh) return 0;
  const std::string prefix = std::string(name) + ": element sh ";
  if (sh->count != count) return invalid_data(prefix + "must have as many rows as element vertex");
  for (int degree = 1; degree <= 3; ++degree) {
    if (sh->properties.size() == static_cast<size_t>(3 * ((degree + 1) * (degree + 1) - 1))) return degree;
  }
  return invalid_data(prefix + "has " + std::to_string(sh->properties.size()) +
                      " properties instead of 9, 24 or 45; export it again");
}

void unpack(const std::vector<ChunkBounds>& chunks, const std::vector<uint32_t>& words,
            GaussianAsset& asset) {
  for (size_t i = 0; i < asset.size(); ++i) {
    const ChunkBounds& bounds = chunks[i / kChunk];
    const uint32_t* word = &words[4 * i];
    asset.positions[i] = bounds.lerp(0, unpack_11_10_11(word[0]));
    asset.rotations[i] = unpack_rotation(word[1]);
    asset.log_scales[i] = bounds.lerp(6, unpack_11_10_11(word[2]));
    const Eigen::Vector3f rgb(static_cast<float>(word[3] >> 24), static_cast<float>((word[3] >> 16) & 255),
                              static_cast<float>((word[3] >> 8) & 255));
    asset.sh_dc[i] = (bounds.lerp(12, rgb / 255.0f).array() - 0.5f) / kShBand0;
    asset.opacity_logits[i] = logit_of_opacity_byte(word[3] & 255);
  }
}

}  // namespace

bool is_compressed_ply(const PlyHeader& header) {
  const PlyElement* vertex = header.find("vertex");
  return header.find("chunk") && vertex && vertex->find("packed_position");
}

Result<AssetFile> read_compressed_ply(const PlyHeader& header, Bytes bytes, std::string_view name) {
  const PlyElement& chunk = *header.find("chunk");
  const PlyElement& vertex = *header.find("vertex");
  const PlyElement* sh = header.find("sh");
  if (vertex.count == 0) return invalid_data(std::string(name) + ": element vertex has no rows");
  if (chunk.count < (vertex.count + kChunk - 1) / kChunk) {
    return invalid_data(std::string(name) + ": " + std::to_string(chunk.count) +
                        " chunks of 256 are too few for " + std::to_string(vertex.count) + " kernels");
  }
  const Result<int> degree = sh_degree_of(sh, vertex.count, name);
  if (!degree) return degree.error();
  // Files of the first version have no colour bounds; their colours are between 0 and 1.
  const bool coloured = chunk.find("min_r").has_value();
  Result<std::vector<PlyColumn>> bounds =
      columns_for(chunk, std::span(kBounds).first(coloured ? kBounds.size() : kBoundsWithoutColour), name);
  if (!bounds) return bounds.error();
  Result<std::vector<PlyColumn>> packed = columns_for(vertex, kWords, name);
  if (!packed) return packed.error();

  AssetFile file;
  file.format = AssetFormat::CompressedPly;
  read_ply_comments(header, file);
  file.asset.sh_degree = *degree;
  file.asset.resize(vertex.count);
  std::vector<ChunkBounds> chunks(chunk.count, {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1}});
  std::vector<uint32_t> words(4 * vertex.count);
  for (size_t i = 0; i < bounds->size(); ++i) {
    (*bounds)[i].floats = chunks.data()->value.data() + i;
    (*bounds)[i].stride = kBounds.size();
  }
  for (size_t i = 0; i < packed->size(); ++i) (*packed)[i].words = words.data() + i;

  const size_t rest = file.asset.sh_rest_count();
  std::vector<PlyColumn> coefficients;
  if (sh) {
    for (size_t i = 0; i < 3 * rest; ++i) {
      const std::optional<size_t> index = sh->find("f_rest_" + std::to_string(i));
      if (!index || sh->properties[*index].list_count_type ||
          sh->properties[*index].type != PlyScalar::Uint8) {
        return invalid_data(std::string(name) + ": element sh has no uchar property f_rest_" +
                            std::to_string(i));
      }
      const size_t channel = i / rest, k = i % rest;
      coefficients.push_back(
          {*index, file.asset.sh_rest.data()->data() + 3 * k + channel, nullptr, 3 * rest});
    }
  }

  PlyRows rows(header, bytes, name);
  for (const PlyElement& element : header.elements) {
    std::span<const PlyColumn> columns;
    if (&element == &chunk) columns = *bounds;
    if (&element == &vertex) columns = *packed;
    if (&element == sh) columns = coefficients;
    const Result<void> read = rows.read(element, columns);
    if (!read) return read.error();
  }
  unpack(chunks, words, file.asset);
  for (Eigen::Vector3f& coefficient : file.asset.sh_rest) coefficient = coefficient.unaryExpr(&unpack_sh);
  return file;
}

}  // namespace livegs
