// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <stop_token>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"

namespace livegs {

// A captured room whose kernels are cut at the borders of its things. Each kernel has a label: the number of
// its thing, 0 for the room itself, and a kind in the two highest bits. The labels contain all decisions. The
// room with any of its things taken can be computed again from them, with the same bits.
struct LabelledRoom {
  GaussianAsset asset;
  std::vector<uint16_t> label;
};
inline constexpr uint16_t kThingMask = 0x3fff;  // the number
enum class KernelKind : uint16_t {
  Own = 0,             // of the room or the thing
  Covered = 0x4000,    // of the room, below or in the shade of the thing: drawn until it is taken
  Fill = 0x8000,       // drawn in the room once the thing is taken
  Underside = 0xc000,  // of the thing, below its place; never drawn in the room
};
inline KernelKind kind_of(uint16_t label) { return static_cast<KernelKind>(label & ~kThingMask); }
inline uint16_t label_of(KernelKind kind, uint16_t thing) {
  return static_cast<uint16_t>(static_cast<uint16_t>(kind) | thing);
}

// Splits the kernels across the borders of the parts, and adds the fill and the underside of each thing
// (separate/fill_behind.h). After a stop request the result is incomplete.
LabelledRoom label_room(const GaussianAsset& asset, const RoomParts& parts, const std::stop_token& stop = {});

// The room without some of its things, and with their fills; kernels keep their order. `kept`, if given, gets
// the index of each kernel in the labelled room.
GaussianAsset room_without(const LabelledRoom& room, std::span<const uint32_t> taken,
                           std::vector<uint32_t>* kept = nullptr);
// The kernels of one thing, including its underside.
GaussianAsset thing_alone(const LabelledRoom& room, uint16_t thing);

// NAME.labels has the labels ("LGSLAB1\n", the count as u64, one u16 per kernel, little-endian) and NAME.ply
// the kernels. The labels are written last, so that a room that can be read is whole. Errors name the file.
Result<void> write_labelled_room(const std::filesystem::path& labels, const LabelledRoom& room);
Result<LabelledRoom> read_labelled_room(const std::filesystem::path& labels);

}  // namespace livegs
