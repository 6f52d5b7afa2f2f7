// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "gaussian/asset/bytes.h"
#include "gaussian/asset_frame.h"

// Extension records of .spz: u32 type, u32 length, then the payload. Readers skip unknown types. Versions 1
// to 3 have them after the planes, version 4 between header and table. A flag of the header marks their
// presence.

namespace livegs {

// The lines of asset_frame.h. The upper half is the vendor: "LV".
inline constexpr uint32_t kSpzFrameRecord = 0x4c560001;
inline constexpr size_t kMaxSpzExtensionBytes = 65536;

// The record, or nothing if the frame is that of any .spz: y up, metres, no origin.
std::vector<std::byte> spz_frame_record(const AssetFrame& frame);

// Reads our record from `records`; the rest is skipped, damage ends the search.
void read_spz_frame(Bytes records, AssetFrame& frame, std::vector<std::string>& notes);

}  // namespace livegs
