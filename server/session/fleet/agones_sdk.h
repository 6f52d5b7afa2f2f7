// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

class HttpClient;

// Annotations of a GameServer that its operator sets before it ends: where its clients continue. HOST:PORT,
// and the name of that GameServer, for which new tokens are signed.
inline constexpr const char* kNextAddressAnnotation = "livegs.io/next-address";
inline constexpr const char* kNextServerAnnotation = "livegs.io/next-server";

// The GameServer of this process, as its sidecar describes it.
struct GameServer {
  std::string name;
  std::string state;                      // "Ready", "Allocated", …
  std::string next_address, next_server;  // the annotations above; empty: not set
};

// The REST interface of the Agones SDK: a sidecar in the same pod. As of Agones 1.41, the first version with
// counters at v1beta1. Each call takes at most kSdkCallTimeout_s, or until `stop`. One thread at a time.
//
// Errors: NotFound for what the GameServer does not have, a path or a counter; Unavailable if no reply
// arrives or the sidecar is at fault (status 500 and above), so that a repetition may succeed; Internal for
// any other reply that is not a success.
class AgonesSdk {
 public:
  // `port`: of the sidecar on this machine.
  explicit AgonesSdk(int port);
  ~AgonesSdk();
  // AGONES_SDK_HTTP_PORT, which Agones sets; 9358 without it. InvalidArgument if it is not a port.
  static Result<int> port_of_environment();
  std::string url() const { return url_; }

  Result<GameServer> game_server(std::stop_token stop = {});
  // The states of a GameServer.
  Result<void> ready(std::stop_token stop = {});
  Result<void> allocate(std::stop_token stop = {});
  Result<void> shutdown(std::stop_token stop = {});
  Result<void> health(std::stop_token stop = {});
  // Sets the label agones.dev/sdk-KEY. `value`: at most 63 letters, digits, '-', '_' and '.'.
  Result<void> set_label(const std::string& key, const std::string& value, std::stop_token stop = {});
  // Sets a counter that the GameServer's spec declares. NotFound if it does not.
  Result<void> set_counter(const std::string& name, uint64_t count, uint64_t capacity,
                           std::stop_token stop = {});

 private:
  Result<std::string> call(std::string_view method, const std::string& path, std::string body,
                           std::stop_token stop);
  const std::string url_;
  const std::unique_ptr<HttpClient> http_;
};

// Parses the reply to GET /gameserver. InvalidData for any other text.
Result<GameServer> parse_game_server(std::string_view json);

}  // namespace livegs
