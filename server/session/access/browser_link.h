// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace livegs {

// IPv4 addresses of this machine, loopback last. (A link with an IPv6 address of the LAN is too long to
// type.)
std::vector<std::string> machine_addresses();

// The address of the page for each address of this machine at which the server listens. `host`: of --listen;
// 0.0.0.0 and [::] stand for all addresses of the machine, first those that other machines reach. `code`: in
// the fragment, which browsers do not send; empty: none.
std::vector<std::string> browser_links(const std::string& host, int port, bool secure,
                                       const std::string& code);

}  // namespace livegs
