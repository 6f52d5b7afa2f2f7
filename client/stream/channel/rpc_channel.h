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

// gRPC's connections and statuses, for the sources of this room only.

namespace livegs {

// Not connected yet. `access`: null for a server in the clear.
std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const ServerAccess* access);

// Waits so long, or until the caller wants to stop: then true.
using WaitOrStop = std::function<bool(int64_t duration_ns)>;

// A connection that is up. Opens a fresh one after each pause of the retry schedule and takes whichever is
// ready first: one whose first packets were lost would wait for seconds. Nothing when `give_up_ns` of
// now_ns() has passed, the caller wants to stop, or the server shows another certificate than it should: then
// `access` says so.
std::shared_ptr<grpc::Channel> connect_channel(const std::string& address, const ServerAccess* access,
                                               int64_t give_up_ns, const WaitOrStop& wait);

Error error_from(const grpc::Status& status, const std::string& prefix);
// Whether another try may end otherwise.
bool may_pass(const grpc::Status& status);

}  // namespace livegs
