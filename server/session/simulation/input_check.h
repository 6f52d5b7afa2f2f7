// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "core/input_sample.h"
#include "core/result.h"
#include "core/view_cone.h"
#include "livegs/v1/session.pb.h"

namespace livegs {

// A client is untrusted: nothing of a message reaches the world before it has passed here.
inline constexpr int kMaxSamplesPerMessage = 8;  // a client sends three
inline constexpr double kMaxHandPosition_m = 1000.0;

// The samples of a message, oldest first. Refused, with the field's name: a number that is not finite, a
// position out of the bound above, a vector of the wrong length, a quaternion that is no rotation (norm off
// by over 1 %), trigger or squeeze outside 0..1, sequences that do not rise, more samples than the bound.
Result<std::vector<InputSample>> check_inputs(const v1::ClientMessage& message);

// What the client looks at, if the message says. Refused likewise: an eye out of the bound above, a direction
// whose length is off 1 by over 1 %, an angle outside 0..pi.
Result<std::optional<ViewCone>> check_view(const v1::ClientMessage& message);

}  // namespace livegs
