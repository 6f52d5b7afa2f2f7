// SPDX-License-Identifier: Apache-2.0
#include "gaussian/progressive/column_codec.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace livegs {
namespace {

enum class Way : uint8_t { Planes = 0, Differences = 1, Palette = 2 };

// Maps float bits to integers in the same order, and back.
uint32_t ordered(uint32_t word) { return word & 0x80000000u ? ~word : word | 0x80000000u; }
uint32_t unordered(uint32_t number) { return number & 0x80000000u ? number & 0x7FFFFFFFu : ~number; }

uint32_t zigzag(uint32_t difference) { return difference << 1 ^ (difference & 0x80000000u ? ~0u : 0u); }
uint32_t unzigzag(uint32_t folded) { return folded >> 1 ^ (folded & 1 ? ~0u : 0u); }

std::vector<uint32_t> differences_of(std::span<const uint32_t> words) {
  std::vector<uint32_t> folded(words.size());
  uint32_t before = 0;
  for (size_t i = 0; i < words.size(); ++i) {
    const uint32_t number = ordered(words[i]);
    folded[i] = zigzag(number - before);
    before = number;
  }
  return folded;
}

// Size under an ideal byte-wise entropy coder of `width` planes, bytes.
double entropy_bytes(std::span<const uint32_t> words, int width) {
  std::array<std::array<uint32_t, 256>, 4> counts{};
  for (const uint32_t word : words) {
    for (int plane = 0; plane < width; ++plane)
      ++counts[static_cast<size_t>(plane)][word >> (8 * plane) & 0xFF];
  }
  double bits = 0;
  const double total = static_cast<double>(words.size());
  for (const auto& of_plane : counts) {
    for (const uint32_t count : of_plane) {
      if (count > 0) bits += count * std::log2(total / count);
    }
  }
  return bits / 8;
}

void append_planes(ColumnBytes& out, std::span<const uint32_t> words, int width) {
  for (int plane = 0; plane < width; ++plane) {
    for (const uint32_t word : words) out.bytes.push_back(static_cast<std::byte>(word >> (8 * plane)));
    out.ends.push_back(out.bytes.size());
  }
}

// The distinct values, ascending; empty if there are too many for a palette to pay off.
std::vector<uint32_t> palette_of(std::span<const uint32_t> words) {
  constexpr size_t kLook = 1024;
  std::vector<uint32_t> values(words.begin(),
                               words.begin() + static_cast<std::ptrdiff_t>(std::min(kLook, words.size())));
  const auto keep_distinct = [&] {
    std::sort(values.begin(), values.end(), [](uint32_t a, uint32_t b) { return ordered(a) < ordered(b); });
    values.erase(std::unique(values.begin(), values.end()), values.end());
  };
  keep_distinct();
  if (words.size() > kLook) {
    if (4 * values.size() > 3 * kLook) return {};
    values.assign(words.begin(), words.end());
    keep_distinct();
  }
  if (2 * values.size() > words.size() || values.size() > 65536) return {};
  return values;
}

int index_width(size_t palette) { return palette <= 256 ? 1 : 2; }

void take_plane(Bytes& bytes, std::span<uint32_t> words, int plane) {
  for (size_t i = 0; i < words.size(); ++i)
    words[i] |= static_cast<uint32_t>(byte_at(bytes, i)) << (8 * plane);
  bytes = bytes.subspan(words.size());
}

bool take_planes(Bytes& bytes, std::span<uint32_t> words, int width) {
  if (words.size() > bytes.size() / static_cast<size_t>(width)) return false;
  std::fill(words.begin(), words.end(), 0);
  for (int plane = 0; plane < width; ++plane) take_plane(bytes, words, plane);
  return true;
}

void sum_up(std::span<uint32_t> folded) {
  uint32_t before = 0;
  for (uint32_t& word : folded) {
    before += unzigzag(word);
    word = unordered(before);
  }
}

}  // namespace

ColumnBytes encode_column(std::span<const uint32_t> words) {
  const std::vector<uint32_t> folded = differences_of(words), palette = palette_of(words);
  double least = entropy_bytes(words, 4);
  Way way = Way::Planes;
  if (const double bytes = entropy_bytes(folded, 4); bytes < least) {
    least = bytes;
    way = Way::Differences;
  }
  std::vector<uint32_t> indices, steps;
  if (!palette.empty()) {
    indices.resize(words.size());
    for (size_t i = 0; i < words.size(); ++i) {
      const auto found = std::lower_bound(palette.begin(), palette.end(), words[i],
                                          [](uint32_t a, uint32_t b) { return ordered(a) < ordered(b); });
      indices[i] = static_cast<uint32_t>(found - palette.begin());
    }
    steps = differences_of(palette);
    if (entropy_bytes(steps, 4) + entropy_bytes(indices, index_width(palette.size())) < least)
      way = Way::Palette;
  }
  ColumnBytes out;
  out.bytes.reserve(max_column_bytes(words.size()));
  out.bytes.push_back(static_cast<std::byte>(way));
  switch (way) {
    case Way::Planes:
      append_planes(out, words, 4);
      break;
    case Way::Differences:
      append_planes(out, folded, 4);
      break;
    case Way::Palette:
      append(out.bytes, static_cast<uint32_t>(palette.size()));
      append_planes(out, steps, 4);
      append_planes(out, indices, index_width(palette.size()));
      break;
  }
  return out;
}

bool decode_column(Bytes& bytes, std::span<uint32_t> words) {
  if (bytes.empty()) return false;
  const unsigned way = byte_at(bytes, 0);
  bytes = bytes.subspan(1);
  if (way == static_cast<unsigned>(Way::Planes)) return take_planes(bytes, words, 4);
  if (way == static_cast<unsigned>(Way::Differences)) {
    if (!take_planes(bytes, words, 4)) return false;
    sum_up(words);
    return true;
  }
  if (way != static_cast<unsigned>(Way::Palette) || bytes.size() < sizeof(uint32_t)) return false;
  const size_t count = load<uint32_t>(bytes, 0);
  bytes = bytes.subspan(sizeof(uint32_t));
  if (count == 0 || 2 * count > words.size() || count > 65536) return false;
  std::vector<uint32_t> palette(count);
  if (!take_planes(bytes, palette, 4)) return false;
  sum_up(palette);
  if (!take_planes(bytes, words, index_width(count))) return false;
  for (uint32_t& word : words) {
    if (word >= count) return false;
    word = palette[word];
  }
  return true;
}

}  // namespace livegs
