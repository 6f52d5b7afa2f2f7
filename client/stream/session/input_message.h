// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/input_sample.h"
#include "core/view_cone.h"
#include "livegs/v1/session.pb.h"

namespace livegs {

void write_input(const InputSample& sample, v1::Input& message);
void write_view(const ViewCone& view, v1::View& message);

}  // namespace livegs
