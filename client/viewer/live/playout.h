// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stream/received/received.h"
#include "viewer/live/frame_playout.h"

namespace livegs {

using Playout = FramePlayout<ReceivedFrame>;

}  // namespace livegs
