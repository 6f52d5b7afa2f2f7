// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/generic/generic_stub.h>

#include <boost/asio/thread_pool.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "web/byte_stream.h"
#include "web/coded_assets.h"
#include "web/web_server.h"

// Internal to web_server.cpp: state shared by all connections.

namespace livegs::web {

using Request = http::request<http::string_body>;

inline constexpr std::string_view kStreamPath = "/livegs.v1.LiveGs/Stream";

inline grpc::ByteBuffer buffer_of(std::string_view bytes) {
  const grpc::Slice slice(bytes.data(), bytes.size());
  return {&slice, 1};
}

inline std::string text_of(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string text;
  if (!buffer.Dump(&slices).ok()) return text;
  for (const grpc::Slice& slice : slices)
    text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return text;
}

struct Shared {
  explicit Shared(WebBackend& given) : backend(given), stub(given.channel()) {}

  WebBackend& backend;
  asio::io_context io{1};
  asio::ssl::context tls{asio::ssl::context::tls_server};
  bool secure = false;
  grpc::GenericStub stub;
  asio::thread_pool pool{1};
  CodedAssets assets;
  std::vector<std::string> origins;  // allow_origins()
  std::string store_origin;          // connect_to()
  bool closing = false;              // on the io thread
  // A connection. It is closed at shutdown. Its last owner may be a thread of gRPC.
  struct Open {
    virtual void end() = 0;
    virtual ~Open() = default;
  };
  void add(const std::shared_ptr<Open>& one) {
    std::lock_guard lock(mutex);
    std::erase_if(open, [](const std::weak_ptr<Open>& known) { return known.expired(); });
    open.push_back(one);
  }
  std::mutex mutex;  // guards open
  std::vector<std::weak_ptr<Open>> open;
};

}  // namespace livegs::web
