// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/support/status.h>

#include "core/log.h"
#include "core/result.h"
#include "session/support/redact_paths.h"

namespace livegs {

// Maps an ErrorCode to a gRPC code. Paths of this machine are redacted for the client; the log keeps the full
// message.
inline grpc::Status to_status(const Error& error) {
  const auto code = [&] {
    switch (error.code) {
      case ErrorCode::InvalidArgument:
      case ErrorCode::InvalidData:
        return grpc::StatusCode::INVALID_ARGUMENT;
      case ErrorCode::NotFound:
        return grpc::StatusCode::NOT_FOUND;
      case ErrorCode::Unsupported:
        return grpc::StatusCode::UNIMPLEMENTED;
      case ErrorCode::TooLarge:
        return grpc::StatusCode::RESOURCE_EXHAUSTED;
      case ErrorCode::Unavailable:
        return grpc::StatusCode::UNAVAILABLE;
      case ErrorCode::PermissionDenied:
        return grpc::StatusCode::PERMISSION_DENIED;
      case ErrorCode::Internal:
        break;
    }
    return grpc::StatusCode::INTERNAL;
  }();
  std::string message = redact_paths(error.message);
  if (message != error.message) log_warn("client request failed: %s", error.message.c_str());
  return {code, std::move(message)};
}

}  // namespace livegs
