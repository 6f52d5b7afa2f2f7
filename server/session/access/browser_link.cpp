// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/access/browser_link.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <memory>

namespace livegs {

std::vector<std::string> machine_addresses() {
  ifaddrs* found = nullptr;
  if (::getifaddrs(&found) != 0) return {"127.0.0.1"};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all(found, &::freeifaddrs);
  std::vector<std::string> addresses;
  for (const ifaddrs* one = found; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET || (one->ifa_flags & IFF_UP) == 0 ||
        (one->ifa_flags & IFF_LOOPBACK) != 0)
      continue;
    char text[INET_ADDRSTRLEN] = "";
    const auto& address = *reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    if (::inet_ntop(AF_INET, &address.sin_addr, text, sizeof text) != nullptr) addresses.emplace_back(text);
  }
  addresses.emplace_back("127.0.0.1");
  return addresses;
}

std::vector<std::string> browser_links(const std::string& host, int port, bool secure,
                                       const std::string& code) {
  const bool any = host == "0.0.0.0" || host == "[::]" || host == "::";
  std::vector<std::string> links;
  for (const std::string& address : any ? machine_addresses() : std::vector<std::string>{host}) {
    links.push_back((secure ? "https://" : "http://") + address + ":" + std::to_string(port) + "/" +
                    (code.empty() ? "" : "#pair=" + code));
  }
  return links;
}

}  // namespace livegs
