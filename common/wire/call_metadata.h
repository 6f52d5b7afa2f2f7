// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Name of the metadata of a FetchAsset call that holds the caller's session id, so that the fetch and the
// stream of a client share one bandwidth cap. Optional.
inline constexpr char kSessionMetadata[] = "livegs-session";

}  // namespace livegs
