// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace livegs {

// Whether a server at HOST:PORT completes a TLS handshake. Sends nothing else and accepts any certificate.
// False if nothing answers, or something without TLS. Takes up to two seconds. Any thread.
bool speaks_tls(const std::string& address);

}  // namespace livegs
