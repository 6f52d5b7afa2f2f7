// SPDX-License-Identifier: Apache-2.0
#include "stream/channel/rpc_channel.h"

#include <grpc/support/log.h>
#include <grpcpp/create_channel.h>

#include <chrono>
#include <deque>
#include <mutex>
#include <random>

#include "core/clock.h"
#include "core/log.h"
#include "stream/channel/retry_schedule.h"

namespace livegs {
namespace {

// Time to poll all connection attempts once.
constexpr int64_t kPollInterval_ns = 5'000'000;
// A scene's rest bodies arrive in one message; frames are smaller.
constexpr int kMaxReplyBytes = 512 << 20;

void quieten_grpc() {
  static std::once_flag once;
  std::call_once(once, [] {
    gpr_set_log_function([](gpr_log_func_args* line) { log_debug("grpc: %s", line->message); });
  });
}

}  // namespace

std::shared_ptr<grpc::Channel> make_channel(const std::string& address, const ServerAccess* access) {
  quieten_grpc();
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxReplyBytes);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // one connection per channel
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);          // the server of a headset is on the same network
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, static_cast<int>(kConnectTimeout_ns / 1'000'000));
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 1000);  // the server permits 500
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 3000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  return grpc::CreateCustomChannel(
      address, access ? access->credentials() : grpc::InsecureChannelCredentials(), arguments);
}

std::shared_ptr<grpc::Channel> connect_channel(const std::string& address, const ServerAccess* access,
                                               int64_t give_up_ns, const WaitOrStop& wait) {
  struct Attempt {
    std::shared_ptr<grpc::Channel> channel;
    int64_t begun_ns = 0;
  };
  std::deque<Attempt> attempts;
  std::minstd_rand random(std::random_device{}());
  const int64_t begun_ns = now_ns();
  int64_t next_ns = begun_ns;
  for (;;) {
    const int64_t now = now_ns();
    if (now >= next_ns) {
      attempts.push_back({make_channel(address, access), now});
      next_ns = now + retry_pause_ns(now - begun_ns, static_cast<uint32_t>(random()));
    }
    // One after the other: gRPC makes progress on a connection only while a thread waits for it.
    for (const Attempt& attempt : attempts) {
      const std::chrono::nanoseconds share(kPollInterval_ns / static_cast<int64_t>(attempts.size()));
      if (attempt.channel->WaitForConnected(std::chrono::system_clock::now() + share)) return attempt.channel;
    }
    std::erase_if(attempts, [&](const Attempt& attempt) {
      return attempt.channel->GetState(false) == GRPC_CHANNEL_TRANSIENT_FAILURE ||
             now - attempt.begun_ns > kConnectTimeout_ns;
    });
    if (access && !access->refused()) return nullptr;
    if (now >= give_up_ns || wait(attempts.empty() ? kPollInterval_ns : 0)) return nullptr;
  }
}

bool may_pass(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:        // the server is down, shutting down, or building its scene
    case grpc::StatusCode::CANCELLED:          // the server timed the session out
    case grpc::StatusCode::DEADLINE_EXCEEDED:  // a reply was lost
    case grpc::StatusCode::NOT_FOUND:          // the server discarded the session
    case grpc::StatusCode::ALREADY_EXISTS:
    case grpc::StatusCode::ABORTED:
    case grpc::StatusCode::RESOURCE_EXHAUSTED:  // another client took the slot
    case grpc::StatusCode::INTERNAL:            // gRPC's code for a connection that broke inside a frame
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::OK:  // the stream ended without a status
      return true;
    default:
      return false;
  }
}

Error requires_tls(const std::string& address) {
  return {ErrorCode::PermissionDenied,
          address +
              ": a server answers with TLS; pair with --pair CODE, using the code that it prints at start, "
              "and give its token with --token-file"};
}

Error error_from(const grpc::Status& status, const std::string& prefix) {
  const auto code = [&] {
    switch (status.error_code()) {
      case grpc::StatusCode::NOT_FOUND:
        return ErrorCode::NotFound;
      case grpc::StatusCode::FAILED_PRECONDITION:
      case grpc::StatusCode::UNIMPLEMENTED:
        return ErrorCode::Unsupported;
      case grpc::StatusCode::INVALID_ARGUMENT:
      case grpc::StatusCode::OUT_OF_RANGE:
        return ErrorCode::InvalidArgument;
      case grpc::StatusCode::UNAUTHENTICATED:
      case grpc::StatusCode::PERMISSION_DENIED:
        return ErrorCode::PermissionDenied;
      case grpc::StatusCode::RESOURCE_EXHAUSTED:
        return ErrorCode::TooLarge;
      case grpc::StatusCode::UNAVAILABLE:
      case grpc::StatusCode::CANCELLED:
      case grpc::StatusCode::DEADLINE_EXCEEDED:
      case grpc::StatusCode::ABORTED:
        return ErrorCode::Unavailable;
      default:
        return ErrorCode::Internal;
    }
  }();
  return {code, prefix + ": " + status.error_message()};
}

}  // namespace livegs
