// SPDX-License-Identifier: Apache-2.0
#include "trust/host_port.h"

#include <arpa/inet.h>

#include <charconv>

namespace livegs {

Result<HostPort> parse_host_port(const std::string& text) {
  HostPort parsed;
  const size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? "" : text.substr(colon + 1);
  int number = -1;
  const auto read = std::from_chars(port.data(), port.data() + port.size(), number);
  if (colon == 0 || port.empty() || read.ptr != port.data() + port.size() || read.ec != std::errc() ||
      number < 0 || number > 65535) {
    return invalid_argument(text + ": is not HOST:PORT; give a port from 0 to 65535, as in 127.0.0.1:9780");
  }
  parsed.host = text.substr(0, colon);
  parsed.port = number;
  in_addr address{};
  parsed.loopback =
      parsed.host == "localhost" || parsed.host == "[::1]" ||
      (inet_pton(AF_INET, parsed.host.c_str(), &address) == 1 && parsed.host.starts_with("127."));
  return parsed;
}

}  // namespace livegs
