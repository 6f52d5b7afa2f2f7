// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/result.h"
#include "trust/server_access.h"

// gRPC connections and statuses. Internal to this room.

namespace livegs {

// Creates a channel without connecting. `access`: null for a connection without TLS.
std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const ServerAccess* access);

// Waits for `duration_ns` or until the caller requests a stop; returns true on a stop.
using WaitOrStop = std::function<bool(int64_t duration_ns)>;

// Returns a connected channel. A new connection is opened after each pause of the retry schedule and the
// first that is ready is returned, because one whose first packets were lost would wait for seconds. Null if
// now_ns() passes `give_up_ns`, on a stop, or if the server presents an unexpected certificate; `access`
// holds that error.
std::shared_ptr<grpc::Channel> connect_channel(const std::string& address, const ServerAccess* access,
                                               int64_t give_up_ns, const WaitOrStop& wait);

// The error of a client without TLS whose server answers with TLS.
Error requires_tls(const std::string& address);
Error error_from(const grpc::Status& status, const std::string& prefix);
// Whether a retry may succeed.
bool may_pass(const grpc::Status& status);

}  // namespace livegs
