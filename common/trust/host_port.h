// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/result.h"

namespace livegs {

struct HostPort {
  std::string host;       // as given; IPv6 addresses keep their brackets
  int port = 0;           // 0 to 65535
  bool loopback = false;  // an address of this machine: 127.x.y.z, localhost or [::1]
};

// InvalidArgument, with the text, if it is not HOST:PORT.
Result<HostPort> parse_host_port(const std::string& text);

}  // namespace livegs
