// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"

// Rooms made in code for segmentation: one asset with a known owner for each kernel. Like a capture, a room
// has no kernels where no camera can look: on undersides and where a thing touches a desk or a wall.
//
// Units are metres, in the frame of GaussianAsset (-Y up). Equal arguments give the same bits. Any thread.

namespace livegs {

enum class RoomKind {
  Apart,     // five things on a desk, apart
  Touching,  // three pairs on a desk; the two of a pair touch
  Stacked,   // two stacks on a desk, of two and of three things
  Wall,      // things on a desk against a wall, and one on the wall
  Corner,    // things on the floor in a corner and before it
  Crowded,   // twenty things on a desk
  Empty,     // a desk in a room with nothing on it
};
inline constexpr RoomKind kRoomKinds[] = {RoomKind::Apart, RoomKind::Touching, RoomKind::Stacked,
                                          RoomKind::Wall,  RoomKind::Corner,   RoomKind::Crowded,
                                          RoomKind::Empty};
const char* room_kind_name(RoomKind kind);

struct MadeRoomOptions {
  uint64_t seed = 1;         // of textures, and of places in a crowded room
  double spacing_m = 0.004;  // of kernels on things; those of the room are three times as far apart
  // Omits this thing, and the surface that it hides and shades; the kernels of the rest are the same.
  std::optional<size_t> without = {};
};

struct MadeRoom {
  GaussianAsset asset;
  std::vector<uint16_t> owner;                // per kernel: 0 is the room, i + 1 is thing i
  std::vector<std::string> names;             // of things, also of the one left out
  std::vector<Eigen::AlignedBox3d> bounds_m;  // of things, in the frame of the asset
  Eigen::Vector3d middle_m;                   // of the things, a point to look at
};
MadeRoom make_room(RoomKind kind, const MadeRoomOptions& options = {});

}  // namespace livegs
