// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"

namespace livegs {

// A captured room whose kernels are cut at the borders of its things. Each kernel has a label: 0 for the room, a
// thing's own label, or kFillBit with a thing's label for what is shown in its place once it is taken. What was
// decided is in the labels, so a room with any of its things taken can be made again, with the same bits.
struct LabelledRoom {
  GaussianAsset asset;
  std::vector<uint16_t> label;
};
inline constexpr uint16_t kFillBit = 0x8000;

// The room without some of its things, and with their fills; kernels keep their order. `kept`, if given, gets the
// index of each kernel in the labelled room.
GaussianAsset room_without(const LabelledRoom& room, std::span<const uint32_t> taken,
                           std::vector<uint32_t>* kept = nullptr);

// NAME.labels has the labels ("LGSLAB1\n", the count as u64, one u16 per kernel, little-endian) and NAME.ply the
// kernels. The labels are written last, so that a room that can be read is whole. Errors name the file.
Result<void> write_labelled_room(const std::filesystem::path& labels, const LabelledRoom& room);
Result<LabelledRoom> read_labelled_room(const std::filesystem::path& labels);

}  // namespace livegs
