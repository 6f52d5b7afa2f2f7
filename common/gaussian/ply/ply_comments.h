// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gaussian/asset/decoded_asset.h"
#include "gaussian/ply/ply_header.h"

namespace livegs {

// Reads the statements of the comments about the training and the frame, in any letter case:
//   SplatRenderMode: mip     written by Brush, gsplat, splat-transform: antialiased; default or 2dgs: not
//   antialiased 1            Postshot
//   Vertical Axis: z …       asset_frame.h
void read_ply_comments(const PlyHeader& header, AssetFile& file);

}  // namespace livegs
