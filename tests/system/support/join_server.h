// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "patience.h"
#include "stream/session/session_client.h"

namespace livegs {

// Options of a client that waits and reconnects for as long as tests wait.
inline ConnectOptions patient() {
  ConnectOptions options;
  options.timeout_s = options.reconnect_s = static_cast<double>(kPatience.count());
  return options;
}

// Joins a server on this machine. Returns null and fails the test if the client cannot join.
inline std::unique_ptr<SessionClient> join(int port, const ConnectOptions& options = patient()) {
  auto joined = SessionClient::join("127.0.0.1:" + std::to_string(port), options);
  EXPECT_TRUE(joined) << joined.error().message;
  return joined ? std::move(*joined) : nullptr;
}

}  // namespace livegs
