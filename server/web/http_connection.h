// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "web/page_files.h"
#include "web/socket_bridge.h"

// Answers the requests of one HTTP connection. Decides which origins may call the server, load the view
// module and show the page in a frame (Content-Security-Policy). Internal to web_server.cpp.

namespace livegs::web {

inline constexpr seconds kCallTimeout{30};
inline constexpr std::string_view kServicePath = "/livegs.v1.LiveGs/",
                                  kFetchPath = "/livegs.v1.LiveGs/FetchAsset";
// Streaming RPCs have no answer to a single request.
inline const std::set<std::string, std::less<>> kStreamingRpcs = {"Stream", "FetchAsset", "AnalyzeScene",
                                                                  "UploadAsset"};

// The module of <livegs-view>, which pages of allowed sites load.
inline constexpr std::string_view kViewModule = "/livegs-view.js";

inline std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

inline http::status http_status(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::OK:
      return http::status::ok;
    case grpc::StatusCode::UNAUTHENTICATED:
      return http::status::unauthorized;
    case grpc::StatusCode::PERMISSION_DENIED:
      return http::status::forbidden;
    case grpc::StatusCode::NOT_FOUND:
      return http::status::not_found;
    case grpc::StatusCode::INVALID_ARGUMENT:
    case grpc::StatusCode::OUT_OF_RANGE:
      return http::status::bad_request;
    case grpc::StatusCode::FAILED_PRECONDITION:
      return http::status::precondition_failed;
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return http::status::too_many_requests;
    case grpc::StatusCode::UNAVAILABLE:
      return http::status::service_unavailable;
    case grpc::StatusCode::UNIMPLEMENTED:
      return http::status::not_implemented;
    default:
      return http::status::internal_server_error;
  }
}

// The host of "HOST" or "HOST:PORT", without brackets.
inline std::string_view host_of(std::string_view authority) {
  if (authority.starts_with('[')) return authority.substr(1, authority.find(']') - 1);
  return authority.substr(0, authority.find(':'));
}

inline bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

// Whether the request comes from a page of this server, or from no page. Without tokens, the host must also
// be a local name. This prevents DNS rebinding, in which the name of another site resolves to this machine.
// `any_origin`: the request may come from a page of another site.
inline bool from_own_origin(const Request& request, bool secure, bool any_origin) {
  const std::string_view host = view_of(request[http::field::host]);
  if (!secure && !is_loopback(host_of(host))) return false;
  const auto origin = request.find(http::field::origin);
  if (origin == request.end() || any_origin) return true;
  return view_of(origin->value()) == std::string(secure ? "https://" : "http://") + std::string(host);
}

inline std::map<std::string, std::string> parameters_of(std::string_view query) {
  std::map<std::string, std::string> parameters;
  while (!query.empty()) {
    const size_t end = query.find('&');
    const std::string_view one = query.substr(0, end);
    const size_t equals = one.find('=');
    if (equals != std::string_view::npos) parameters.emplace(one.substr(0, equals), one.substr(equals + 1));
    query = end == std::string_view::npos ? "" : query.substr(end + 1);
  }
  return parameters;
}

// One connection of HTTP/1.1, with any number of requests in turn.
class HttpConnection final : public std::enable_shared_from_this<HttpConnection>, public Shared::Open {
 public:
  HttpConnection(Shared& shared, ByteStream stream) : shared_(shared), stream_(std::move(stream)) {}

  void start() {
    shared_.add(shared_from_this());
    stream_.expires_after(kRequestTimeout);
    stream_.handshake([self = shared_from_this()](error_code failed) {
      if (!failed) self->read(kRequestTimeout);
    });
  }

  void end() override { stream_.close(); }

 private:
  void read(seconds timeout) {
    parser_.emplace();
    parser_->header_limit(kMaxWebHeaderBytes);
    parser_->body_limit(kMaxWebBodyBytes);
    stream_.expires_after(timeout);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code failed, size_t) {
      if (!failed) return self->answer(self->parser_->release());
      if (failed == http::error::body_limit || failed == http::error::header_limit) {
        self->keep_alive_ = false;
        self->send_text(http::status::payload_too_large, "request: is too large\n");
      }
    });
  }

  void answer(Request request) {
    keep_alive_ = request.keep_alive() && !shared_.closing;
    version_ = request.version();
    head_ = request.method() == http::verb::head;
    stream_.expires_after(kAnswerTimeout);
    const std::string target(view_of(request.target()));
    const size_t question = target.find('?');
    const std::string path = target.substr(0, question);
    const auto parameters =
        parameters_of(question == std::string::npos ? "" : std::string_view(target).substr(question + 1));
    if (shared_.secure && !stream_.tls()) return redirect(request, target);
    const std::string_view origin = view_of(request[http::field::origin]);
    const bool may_embed =
        std::find(shared_.origins.begin(), shared_.origins.end(), origin) != shared_.origins.end();
    if (!from_own_origin(request, shared_.secure, may_embed && path == kViewModule))
      return send_text(http::status::forbidden, "origin: pages of other sites may not use this server\n");
    if (path == "/stream" && websocket::is_upgrade(request)) return open_stream(std::move(request));
    const bool get = request.method() == http::verb::get || head_;
    if (get && path.starts_with("/assets/")) return send_asset(request, path.substr(8), parameters);
    if (get) return send_page(request, path);
    if (request.method() == http::verb::post && path == "/pair") return pair(request);
    if (request.method() == http::verb::post && path.starts_with(kServicePath)) return call(request, path);
    send_text(http::status::method_not_allowed, "method: is not served here\n");
  }

  // Redirects a browser that used http:// on a port with TLS.
  void redirect(const Request& request, const std::string& target) {
    http::response<http::empty_body> response{http::status::permanent_redirect, version_};
    response.set(http::field::location,
                 "https://" + std::string(view_of(request[http::field::host])) + target);
    keep_alive_ = false;
    send(std::move(response));
  }

  void send_page(const Request& request, const std::string& path) {
    const PageFile* file = find_page_file(path);
    if (!file) return send_text(http::status::not_found, "path: is not served here\n");
    if (view_of(request[http::field::if_none_match]) == file->etag) {
      http::response<http::empty_body> response{http::status::not_modified, version_};
      response.set(http::field::etag, std::string(file->etag));
      return send(std::move(response));
    }
    const std::string_view accepted = view_of(request[http::field::accept_encoding]);
    std::string_view body = file->bytes, coding;
    if (!file->brotli.empty() && accepts_coding(accepted, "br")) {
      body = file->brotli, coding = "br";
    } else if (!file->gzip.empty() && accepts_coding(accepted, "gzip")) {
      body = file->gzip, coding = "gzip";
    }
    http::response<http::span_body<const char>> response{http::status::ok, version_};
    response.body() = {body.data(), body.size()};
    response.set(http::field::content_type, std::string(file->content_type));
    response.set(http::field::etag, std::string(file->etag));
    response.set(http::field::cache_control,
                 file->named_by_content() ? "public, max-age=31536000, immutable" : "no-store");
    response.set(http::field::vary, "Accept-Encoding, Origin");
    if (!coding.empty()) response.set(http::field::content_encoding, std::string(coding));
    std::string policy = std::string(kPagePolicy) + "; frame-ancestors";
    if (!shared_.store_origin.empty()) {
      constexpr std::string_view kOwn = "connect-src 'self'";
      policy.insert(policy.find(kOwn) + kOwn.size(), " " + shared_.store_origin);
    }
    if (shared_.origins.empty()) policy += " 'none'";
    for (const std::string& origin : shared_.origins) policy += " " + origin;
    response.set("Content-Security-Policy", policy);
    const auto origin = request.find(http::field::origin);
    if (file->path == kViewModule && origin != request.end()) {  // allowed, or it would have been refused
      response.set(http::field::access_control_allow_origin, origin->value());
      response.set("Cross-Origin-Resource-Policy", "cross-origin");
    }
    send(std::move(response));
  }

  void pair(const Request& request) {
    const auto token = shared_.backend.pair(request.body());
    if (!token) return send_text(http::status::unauthorized, token.error().message + "\n");
    send_text(http::status::ok, *token);
  }

  // A unary RPC.
  void call(const Request& request, const std::string& path) {
    const std::string authorization(view_of(request[http::field::authorization]));
    if (kStreamingRpcs.contains(path.substr(kServicePath.size())))
      return send_text(http::status::not_found, "path: is a streaming RPC\n");
    if (const grpc::Status status = shared_.backend.authorise(path, authorization); !status.ok())
      return send_status(status);
    struct Call {
      grpc::ClientContext context;
      grpc::ByteBuffer request, reply;
    };
    const auto call = std::make_shared<Call>();
    if (!authorization.empty()) call->context.AddMetadata("authorization", authorization);
    call->context.set_deadline(std::chrono::system_clock::now() + kCallTimeout);
    call->request = buffer_of(request.body());
    stream_.expires_after(kCallTimeout + kAnswerTimeout);
    shared_.stub.UnaryCall(&call->context, path, {}, &call->request, &call->reply,
                           [self = shared_from_this(), call](const grpc::Status& status) {
                             asio::post(self->shared_.io, [self, call, status] {
                               if (!status.ok()) return self->send_status(status);
                               http::response<http::string_body> response{http::status::ok, self->version_};
                               response.body() = text_of(call->reply);
                               response.set(http::field::content_type, "application/x-protobuf");
                               response.set(http::field::cache_control, "no-store");
                               self->send(std::move(response));
                             });
                           });
  }

  // An asset, at the pace of the client's bandwidth limit.
  void send_asset(const Request& request, const std::string& hash,
                  const std::map<std::string, std::string>& parameters) {
    const std::string authorization(view_of(request[http::field::authorization]));
    if (const grpc::Status status = shared_.backend.authorise(std::string(kFetchPath), authorization);
        !status.ok())
      return send_status(status);
    uint64_t from = 0;
    if (const auto given = parameters.find("from"); given != parameters.end()) {
      const auto [end, failed] =
          std::from_chars(given->second.data(), given->second.data() + given->second.size(), from);
      if (failed != std::errc() || end != given->second.data() + given->second.size())
        return send_text(http::status::bad_request, "from: must be a number of bytes\n");
    }
    const auto given_base = parameters.find("base");
    const std::string base = given_base == parameters.end() ? "" : given_base->second;
    fetch_ =
        shared_.backend.fetch(hash, base, std::string(view_of(request["livegs-session"])), authorization);
    if (!fetch_)
      return send_text(http::status::not_found, base.empty()
                                                    ? "asset: is not an asset of the scene\n"
                                                    : "base: the server has no edit of this asset\n");
    const ContentCoding coding = choose_coding(view_of(request[http::field::accept_encoding]));
    stream_.expires_never();  // the work below has no timeout
    asio::post(shared_.pool, [self = shared_from_this(), name = hash + base, from, coding] {
      auto coded = self->shared_.assets.get(name, self->fetch_->bytes(), from, coding);
      asio::post(self->shared_.io, [self, coded = std::move(coded), coding]() mutable {
        if (!coded) return self->send_text(http::status::bad_request, coded.error().message + "\n");
        self->begin_asset(std::move(*coded), coding);
      });
    });
  }

  void begin_asset(CodedAssets::Coded coded, ContentCoding coding) {
    asset_ = std::move(coded.bytes);
    asset_at_ = 0;
    asset_response_.emplace(http::status::ok, version_);
    set_common(*asset_response_);
    asset_response_->set(http::field::content_type, "application/octet-stream");
    asset_response_->set(http::field::cache_control, "private, max-age=31536000, immutable");
    asset_response_->set(http::field::vary, "Accept-Encoding");
    if (coding != ContentCoding::Identity)
      asset_response_->set(http::field::content_encoding, std::string(name_of(coding)));
    asset_response_->set("livegs-total-bytes", std::to_string(coded.total));
    asset_response_->content_length(asset_->size());
    asset_response_->keep_alive(keep_alive_);
    asset_response_->body().data = nullptr;
    asset_response_->body().more = true;
    asset_serializer_.emplace(*asset_response_);
    stream_.expires_after(kAnswerTimeout);
    http::async_write_header(stream_, *asset_serializer_,
                             [self = shared_from_this()](error_code failed, size_t) {
                               if (failed) return;
                               if (self->head_) return self->asset_done();
                               self->send_part();
                             });
  }

  void send_part() {
    if (asset_at_ == asset_->size()) return asset_done();
    const WebFetch::Turn turn = fetch_->take_turn(std::min(kPartBytes, asset_->size() - asset_at_));
    if (turn.bytes == 0) {
      stream_.expires_never();
      timer_.expires_after(std::chrono::nanoseconds(turn.wait_ns));
      timer_.async_wait([self = shared_from_this()](error_code) {
        if (!self->shared_.closing) self->send_part();
      });
      return;
    }
    auto& body = asset_response_->body();
    body.data = const_cast<std::byte*>(asset_->data() + asset_at_);
    body.size = turn.bytes;
    asset_at_ += turn.bytes;
    body.more = asset_at_ < asset_->size();
    stream_.expires_after(kAnswerTimeout);
    http::async_write(stream_, *asset_serializer_, [self = shared_from_this()](error_code failed, size_t) {
      if (failed && failed != http::error::need_buffer) return;
      self->send_part();
    });
  }

  void asset_done() {
    fetch_.reset();
    asset_serializer_.reset();
    asset_response_.reset();
    asset_.reset();
    next();
  }

  void open_stream(Request request) {
    std::string authorization;
    bool known = false;
    http::token_list protocols(request[http::field::sec_websocket_protocol]);
    for (const auto& one : protocols) {
      const std::string_view name = view_of(one);
      if (name == "livegs.v1") known = true;
      if (name.starts_with("token.")) authorization = "Bearer " + std::string(name.substr(6));
    }
    if (!known) return send_text(http::status::bad_request, "subprotocol: must include livegs.v1\n");
    if (const grpc::Status status = shared_.backend.authorise(std::string(kStreamPath), authorization);
        !status.ok())
      return send_status(status);
    std::make_shared<SocketBridge>(shared_, std::move(stream_), std::move(authorization))->accept(request);
  }

  void send_status(const grpc::Status& status) {
    http::response<http::string_body> response{http_status(status.error_code()), version_};
    response.set("grpc-status", std::to_string(status.error_code()));
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.set(http::field::cache_control, "no-store");
    response.body() = status.error_message();
    send(std::move(response));
  }

  void send_text(http::status status, std::string text) {
    http::response<http::string_body> response{status, version_};
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.set(http::field::cache_control, "no-store");
    response.body() = std::move(text);
    send(std::move(response));
  }

  template <class Response>
  void set_common(Response& response) {
    response.set(http::field::server, "livegs");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Cross-Origin-Embedder-Policy", "require-corp");
    if (response.find("Cross-Origin-Resource-Policy") == response.end())
      response.set("Cross-Origin-Resource-Policy", "same-origin");
  }

  template <class Body>
  void send(http::response<Body> made) {
    const auto response = std::make_shared<http::response<Body>>(std::move(made));
    set_common(*response);
    response->keep_alive(keep_alive_);
    response->prepare_payload();
    stream_.expires_after(kAnswerTimeout);
    const auto sent = [self = shared_from_this(), response](error_code failed, size_t) {
      if (!failed) self->next();
    };
    if (!head_) {
      http::async_write(stream_, *response, sent);
    } else {
      const auto serializer = std::make_shared<http::response_serializer<Body>>(*response);
      http::async_write_header(stream_, *serializer,
                               [sent, serializer](error_code failed, size_t size) { sent(failed, size); });
    }
  }

  void next() {
    if (keep_alive_ && !shared_.closing) return read(kIdleTimeout);
    stream_.shut_down([self = shared_from_this()](error_code) {});
  }

  Shared& shared_;
  ByteStream stream_;
  beast::flat_buffer buffer_{kMaxWebHeaderBytes + kMaxWebBodyBytes};
  std::optional<http::request_parser<http::string_body>> parser_;
  bool keep_alive_ = false, head_ = false;
  unsigned version_ = 11;
  // The asset that is sent.
  std::unique_ptr<WebFetch> fetch_;
  std::shared_ptr<const std::vector<std::byte>> asset_;
  size_t asset_at_ = 0;
  std::optional<http::response<http::buffer_body>> asset_response_;
  std::optional<http::response_serializer<http::buffer_body>> asset_serializer_;
  asio::steady_timer timer_{shared_.io};
};

}  // namespace livegs::web
