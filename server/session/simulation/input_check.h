// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "core/input_sample.h"
#include "core/result.h"
#include "core/view_cone.h"
#include "livegs/v1/session.pb.h"

namespace livegs {

// Validation of client messages. Clients are untrusted: only checked values reach the world.
inline constexpr int kMaxSamplesPerMessage = 8;  // a client sends three per message, or all that are new
inline constexpr double kMaxHandPosition_m = 1000.0;

// The samples of a message, oldest first. Fails with the field's name for:
//   - a number that is not finite, or a position outside kMaxHandPosition_m;
//   - a vector of the wrong length, or a quaternion whose norm differs from 1 by more than 1 %;
//   - trigger or squeeze outside 0..1;
//   - sequences that do not increase, or more than kMaxSamplesPerMessage samples.
Result<std::vector<InputSample>> check_inputs(const v1::ClientMessage& message);

// The view of the client, if the message contains one. Fails likewise for a position outside
// kMaxHandPosition_m, a direction whose length differs from 1 by more than 1 %, or an angle outside 0..pi.
Result<std::optional<ViewCone>> check_view(const v1::ClientMessage& message);

}  // namespace livegs
