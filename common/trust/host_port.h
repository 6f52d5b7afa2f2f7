// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/result.h"

namespace livegs {

struct HostPort {
  std::string host;       // as given; an IPv6 address in its brackets
  int port = 0;           // 0 to 65535
  bool loopback = false;  // an address of this very machine: 127.x.y.z, localhost or [::1]
};

// InvalidArgument, naming the text, when it is not HOST:PORT.
Result<HostPort> parse_host_port(const std::string& text);

}  // namespace livegs
