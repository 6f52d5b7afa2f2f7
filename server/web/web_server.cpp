// SPDX-License-Identifier: GPL-3.0-or-later
// The thread, its TLS and its connections. http_connection.h answers the requests and writes the page's
// policy.
#include "web/web_server.h"

#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>

#include <future>
#include <mutex>
#include <thread>

#include "web/http_connection.h"

namespace livegs {
namespace {

using namespace web;

constexpr seconds kCloseTimeout{1};

}  // namespace

struct WebServer::Parts {
  explicit Parts(WebBackend& backend) : shared(backend) {}
  Shared shared;
  asio::executor_work_guard<asio::io_context::executor_type> work{shared.io.get_executor()};
  std::thread thread;
  std::once_flag closed;
};

WebServer::WebServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
WebServer::~WebServer() { close(); }

Result<std::unique_ptr<WebServer>> WebServer::start(WebBackend& backend, const std::string& certificate_pem,
                                                    const std::string& key_pem) {
  auto parts = std::make_unique<Parts>(backend);
  if (!certificate_pem.empty()) {
    asio::ssl::context& tls = parts->shared.tls;
    error_code failed;
    tls.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                        asio::ssl::context::no_tlsv1_1,
                    failed);
    if (!failed) tls.use_certificate_chain(asio::buffer(certificate_pem), failed);
    if (!failed) tls.use_private_key(asio::buffer(key_pem), asio::ssl::context::pem, failed);
    if (failed) return invalid_data("certificate: cannot be used for TLS: " + failed.message());
    SSL_CTX_set_alpn_select_cb(
        tls.native_handle(),
        [](SSL*, const unsigned char** chosen, unsigned char* length, const unsigned char* offered,
           unsigned offered_length, void*) {
          static constexpr unsigned char kHttp1[] = {8, 'h', 't', 't', 'p', '/', '1', '.', '1'};
          unsigned char* found = nullptr;
          if (SSL_select_next_proto(&found, length, kHttp1, sizeof kHttp1, offered, offered_length) !=
              OPENSSL_NPN_NEGOTIATED)
            return SSL_TLSEXT_ERR_NOACK;
          *chosen = found;
          return SSL_TLSEXT_ERR_OK;
        },
        nullptr);
    parts->shared.secure = true;
  }
  Parts* running = parts.get();
  parts->thread = std::thread([running] {
    pthread_setname_np(pthread_self(), "web");
    running->shared.io.run();
  });
  return std::unique_ptr<WebServer>(new WebServer(std::move(parts)));
}

void WebServer::allow_origins(std::vector<std::string> origins) {
  asio::post(parts_->shared.io, [&shared = parts_->shared, origins = std::move(origins)]() mutable {
    shared.origins = std::move(origins);
  });
}

void WebServer::connect_to(std::string origin) {
  asio::post(parts_->shared.io, [&shared = parts_->shared, origin = std::move(origin)]() mutable {
    shared.store_origin = std::move(origin);
  });
}

void WebServer::take(int socket, bool tls) {
  asio::post(parts_->shared.io, [this, socket, tls] {
    Shared& shared = parts_->shared;
    sockaddr_storage at{};
    socklen_t size = sizeof at;
    tcp::socket adopted(shared.io);
    error_code failed;
    if (shared.closing || ::getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size) != 0 ||
        (adopted.assign(at.ss_family == AF_INET6 ? tcp::v6() : tcp::v4(), socket, failed), failed)) {
      ::close(socket);
      return;
    }
    if (tls && !shared.secure) return;  // closes it
    std::make_shared<HttpConnection>(shared,
                                     ByteStream(shared.io, std::move(adopted), tls ? &shared.tls : nullptr))
        ->start();
  });
}

void WebServer::close() {
  std::call_once(parts_->closed, [this] {
    Shared& shared = parts_->shared;
    asio::post(shared.io, [&shared] {
      shared.closing = true;
      std::vector<std::weak_ptr<Shared::Open>> open;
      {
        std::lock_guard lock(shared.mutex);
        open.swap(shared.open);
      }
      for (const std::weak_ptr<Shared::Open>& one : open) {
        if (const auto kept = one.lock()) kept->end();
      }
    });
    parts_->work.reset();
    std::promise<void> ended;
    std::thread waiter([this, &ended] {
      parts_->thread.join();
      ended.set_value();
    });
    if (ended.get_future().wait_for(kCloseTimeout) != std::future_status::ready) shared.io.stop();
    waiter.join();
    shared.pool.join();
  });
}

}  // namespace livegs
