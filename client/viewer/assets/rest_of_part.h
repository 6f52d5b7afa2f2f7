// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "skin/rest_body.h"

namespace livegs {

// The part of a rest body that belongs to these kernels of the asset; indices ascend.
RestBody rest_of_part(const RestBody& rest, std::span<const uint32_t> indices);

}  // namespace livegs
