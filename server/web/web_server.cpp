// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/web_server.h"

#include <grpcpp/generic/generic_stub.h>
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <chrono>
#include <future>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "core/log.h"
#include "gaussian/stored_blocks.h"
#include "web/content_coding.h"
#include "web/page_files.h"

namespace livegs {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using boost::system::error_code;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Request = http::request<http::string_body>;

// A request, from its first byte, and an answer. A slower client loses its connection.
constexpr seconds kRequestTimeout{5}, kAnswerTimeout{30};
// Between two requests on one connection.
constexpr seconds kIdleTimeout{60};
constexpr seconds kCallTimeout{30};
constexpr seconds kCloseTimeout{1};
// A part of an asset that is written at once.
constexpr size_t kPartBytes = 64u << 10;
// Memory for compressed assets, bytes. An asset that does not fit is compressed for each fetch.
constexpr size_t kMaxKeptAssets = 256u << 20;
// Codes of a closing WebSocket: this plus the status code of gRPC (RFC 6455, section 7.4.2: 4000 to 4999 are
// private).
constexpr int kFirstCloseCode = 4000;
constexpr size_t kMaxCloseReason = 120;  // RFC 6455, section 5.5: 123 bytes

constexpr std::string_view kServicePath = "/livegs.v1.LiveGs/", kStreamPath = "/livegs.v1.LiveGs/Stream",
                           kFetchPath = "/livegs.v1.LiveGs/FetchAsset";
// Streaming RPCs have no answer to a single request.
const std::set<std::string, std::less<>> kStreamingRpcs = {"Stream", "FetchAsset", "AnalyzeScene",
                                                           "UploadAsset"};

constexpr const char* kContentSecurityPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; img-src 'self' data:; "
    "style-src 'self'; "
    "worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

http::status http_status(grpc::StatusCode code) {
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
std::string_view host_of(std::string_view authority) {
  if (authority.starts_with('[')) return authority.substr(1, authority.find(']') - 1);
  return authority.substr(0, authority.find(':'));
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

// Whether the request comes from a page of this server, or from no page. Without tokens, the host must also
// be this machine by name, so that a page of another site whose name leads here (DNS rebinding) is refused.
bool from_own_origin(const Request& request, bool secure) {
  const std::string_view host = view_of(request[http::field::host]);
  if (!secure && !is_loopback(host_of(host))) return false;
  const auto origin = request.find(http::field::origin);
  if (origin == request.end()) return true;
  return view_of(origin->value()) == std::string(secure ? "https://" : "http://") + std::string(host);
}

grpc::ByteBuffer buffer_of(std::string_view bytes) {
  const grpc::Slice slice(bytes.data(), bytes.size());
  return {&slice, 1};
}

std::string text_of(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string text;
  if (!buffer.Dump(&slices).ok()) return text;
  for (const grpc::Slice& slice : slices)
    text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return text;
}

std::map<std::string, std::string> parameters_of(std::string_view query) {
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

using Bytes = std::shared_ptr<const std::vector<std::byte>>;

// Assets as browsers receive them, compressed once. Used by the pool's thread.
class CodedAssets {
 public:
  struct Coded {
    Bytes bytes;
    uint64_t total = 0;  // bytes of the whole stored form
  };
  Result<Coded> get(const std::string& hash, std::span<const std::byte> progressive, uint64_t from,
                    ContentCoding coding) {
    const std::string key = hash + ' ' + std::string(name_of(coding));
    if (from == 0) {
      for (auto one = kept_.begin(); one != kept_.end(); ++one) {
        if (one->key != key) continue;
        kept_.splice(kept_.begin(), kept_, one);
        return one->coded;
      }
    }
    auto stored = store_blocks(progressive);
    if (!stored) return stored.error();
    if (from > stored->size())
      return invalid_argument("from: is past the end of the asset, " + std::to_string(stored->size()) +
                              " bytes");
    auto coded = encode_content(std::span(*stored).subspan(from), coding);
    if (!coded) return coded.error();
    Coded made{std::make_shared<const std::vector<std::byte>>(*std::move(coded)), stored->size()};
    if (from == 0 && made.bytes->size() <= kMaxKeptAssets) {
      kept_.push_front({key, made});
      kept_bytes_ += made.bytes->size();
      while (kept_bytes_ > kMaxKeptAssets) {
        kept_bytes_ -= kept_.back().coded.bytes->size();
        kept_.pop_back();
      }
    }
    return made;
  }

 private:
  struct Kept {
    std::string key;
    Coded coded;
  };
  std::list<Kept> kept_;  // most recent first
  size_t kept_bytes_ = 0;
};

struct Shared {
  explicit Shared(WebBackend& given) : backend(given), stub(given.channel()) {}

  WebBackend& backend;
  asio::io_context io{1};
  asio::ssl::context tls{asio::ssl::context::tls_server};
  bool secure = false;
  grpc::GenericStub stub;
  asio::thread_pool pool{1};
  CodedAssets assets;
  bool closing = false;  // on the io thread
  // A connection, which is ended at shutdown. Its last owner may be a thread of gRPC.
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

// A TCP connection, with TLS or without. Its handlers have one type, so that Beast's algorithms are compiled
// once. At most one read and one write are in progress.
class ByteStream {
 public:
  using executor_type = asio::io_context::executor_type;
  using Done = std::function<void(error_code, size_t)>;

  ByteStream(asio::io_context& io, tcp::socket socket, asio::ssl::context* tls)
      : parts_(std::make_unique<Parts>(io, std::move(socket), tls)) {}

  executor_type get_executor() const { return parts_->io.get_executor(); }
  bool tls() const { return parts_->tls.has_value(); }
  void expires_after(std::chrono::nanoseconds time) { parts_->tcp.expires_after(time); }
  void expires_never() { parts_->tcp.expires_never(); }
  void close() { parts_->tcp.close(); }

  void handshake(std::function<void(error_code)> done) {
    if (!parts_->tls) return done({});
    parts_->tls->async_handshake(asio::ssl::stream_base::server, std::move(done));
  }
  void shut_down(std::function<void(error_code)> done) {
    if (parts_->tls) {
      parts_->tcp.expires_after(kRequestTimeout);
      return parts_->tls->async_shutdown(std::move(done));
    }
    error_code failed;
    parts_->tcp.socket().shutdown(tcp::socket::shutdown_send, failed);
    asio::post(parts_->io, [done = std::move(done), failed] { done(failed); });
  }

  // The concept AsyncStream of Asio.
  template <class Buffers, class Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(error_code, size_t)>(
        [this](auto handler, asio::mutable_buffer to) { read(to, erased(std::move(handler))); }, token,
        first_of(buffers));
  }
  template <class Buffers, class Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(error_code, size_t)>(
        [this](auto handler, asio::const_buffer from) { write(from, erased(std::move(handler))); }, token,
        joined(buffers));
  }

 private:
  struct Parts {
    Parts(asio::io_context& given, tcp::socket socket, asio::ssl::context* context)
        : io(given), tcp(std::move(socket)) {
      if (context) tls.emplace(tcp, *context);
    }
    asio::io_context& io;
    beast::tcp_stream tcp;
    std::optional<asio::ssl::stream<beast::tcp_stream&>> tls;
    std::vector<char> together;  // several buffers of one write
  };

  // std::function copies its callable, which handlers do not allow.
  template <class Handler>
  static Done erased(Handler handler) {
    return [shared = std::make_shared<Handler>(std::move(handler))](error_code failed, size_t size) {
      std::move (*shared)(failed, size);
    };
  }
  template <class Buffers>
  static asio::mutable_buffer first_of(const Buffers& buffers) {
    for (auto one = asio::buffer_sequence_begin(buffers); one != asio::buffer_sequence_end(buffers); ++one) {
      if (asio::mutable_buffer(*one).size() > 0) return *one;
    }
    return {};
  }
  // All buffers in one, so that the head and the body of a message are one segment.
  template <class Buffers>
  asio::const_buffer joined(const Buffers& buffers) {
    size_t count = 0, total = 0;
    asio::const_buffer only;
    for (auto one = asio::buffer_sequence_begin(buffers); one != asio::buffer_sequence_end(buffers); ++one) {
      const asio::const_buffer buffer(*one);
      if (buffer.size() == 0) continue;
      only = buffer;
      ++count;
      total += buffer.size();
    }
    if (count <= 1) return only;
    std::vector<char>& together = parts_->together;
    together.resize(std::min(total, kPartBytes));
    return {together.data(), asio::buffer_copy(asio::buffer(together), buffers)};
  }
  void read(asio::mutable_buffer to, Done done) {
    if (parts_->tls)
      parts_->tls->async_read_some(to, std::move(done));
    else
      parts_->tcp.async_read_some(to, std::move(done));
  }
  void write(asio::const_buffer from, Done done) {
    if (parts_->tls)
      parts_->tls->async_write_some(from, std::move(done));
    else
      parts_->tcp.async_write_some(from, std::move(done));
  }

  std::unique_ptr<Parts> parts_;
};

// Customisation points of Beast's WebSocket: the end of the connection.
void beast_close_socket(ByteStream& stream) { stream.close(); }
template <class Handler>
void async_teardown(beast::role_type, ByteStream& stream, Handler&& handler) {
  stream.shut_down([shared = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler))](
                       error_code failed) { std::move (*shared)(failed); });
}

// A WebSocket that is a Stream RPC: one message of a browser is one message of the RPC, and the other way
// round. One message each way is on its way at a time, so that a slow browser stops the server's writing as a
// slow gRPC client does.
class SocketBridge final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                           public std::enable_shared_from_this<SocketBridge>,
                           public Shared::Open {
 public:
  SocketBridge(Shared& shared, ByteStream stream, std::string authorization)
      : shared_(shared), socket_(std::move(stream)), authorization_(std::move(authorization)) {}

  void accept(const Request& request) {
    shared_.add(shared_from_this());
    socket_.next_layer().expires_never();
    websocket::stream_base::timeout timeout{kRequestTimeout, kIdleTimeout, true};
    socket_.set_option(timeout);
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, "livegs.v1");
      response.set(http::field::server, "livegs");
    }));
    socket_.read_message_max(kMaxWebBodyBytes);
    socket_.binary(true);
    socket_.async_accept(request, [self = shared_from_this()](error_code failed) {
      if (!failed) self->begin();
    });
  }

  void end() override { context_.TryCancel(); }

 private:
  void begin() {
    if (!authorization_.empty()) context_.AddMetadata("authorization", authorization_);
    shared_.stub.PrepareBidiStreamingCall(&context_, std::string(kStreamPath), {}, this);
    call_ = shared_from_this();
    AddHold();  // for writes, which begin outside of the reactions
    AddHold();  // for reads
    StartRead(&incoming_);
    StartCall();
    read_socket();
  }

  // From the browser.
  void read_socket() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code failed, size_t) {
      if (failed || self->ended_) return self->stop_writing();
      const auto bytes = self->buffer_.cdata();
      self->outgoing_ = buffer_of({static_cast<const char*>(bytes.data()), bytes.size()});
      self->buffer_.consume(bytes.size());
      self->writing_ = true;
      self->StartWrite(&self->outgoing_);
    });
  }
  void OnWriteDone(bool ok) override {
    asio::post(shared_.io, [self = shared_from_this(), ok] {
      self->writing_ = false;
      if (ok && !self->ended_)
        self->read_socket();
      else
        self->stop_writing();
    });
  }
  void stop_writing() {
    if (std::exchange(writing_ended_, true)) return;
    if (!ended_) context_.TryCancel();
    RemoveHold();
  }

  // To the browser.
  void OnReadDone(bool ok) override {
    asio::post(shared_.io, [self = shared_from_this(), ok] {
      if (!ok) return self->end_of_call();
      self->message_ = text_of(self->incoming_);
      self->socket_.async_write(asio::buffer(self->message_), [self](error_code failed, size_t) {
        if (failed) return self->stop_reading();
        self->StartRead(&self->incoming_);
      });
    });
  }
  void stop_reading() {
    if (std::exchange(reading_ended_, true)) return;
    if (!ended_) context_.TryCancel();
    RemoveHold();
  }
  // The server has ended the call; its status follows when no operation is left.
  void end_of_call() {
    ended_ = true;
    stop_reading();
    if (!writing_) stop_writing();
  }

  void OnDone(const grpc::Status& status) override {
    asio::post(shared_.io, [self = shared_from_this(), status] {
      self->ended_ = true;
      websocket::close_reason reason(static_cast<uint16_t>(kFirstCloseCode + status.error_code()));
      const std::string text = status.error_message().substr(0, kMaxCloseReason);
      reason.reason.assign(text.data(), text.size());
      self->socket_.async_close(reason, [self](error_code) {});
      self->call_.reset();
    });
  }

  Shared& shared_;
  websocket::stream<ByteStream> socket_;
  const std::string authorization_;
  grpc::ClientContext context_;
  grpc::ByteBuffer incoming_, outgoing_;
  beast::flat_buffer buffer_;
  std::string message_;
  std::shared_ptr<SocketBridge> call_;  // gRPC's reference, released after OnDone
  bool writing_ = false;                // a message is on its way to the call
  bool writing_ended_ = false, reading_ended_ = false, ended_ = false;
};

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
    if (!from_own_origin(request, shared_.secure))
      return send_text(http::status::forbidden, "origin: pages of other sites may not use this server\n");
    if (path == "/stream" && websocket::is_upgrade(request)) return open_stream(std::move(request));
    const bool get = request.method() == http::verb::get || head_;
    if (get && path.starts_with("/assets/")) return send_asset(request, path.substr(8), parameters);
    if (get) return send_page(request, path);
    if (request.method() == http::verb::post && path == "/pair") return pair(request);
    if (request.method() == http::verb::post && path.starts_with(kServicePath)) return call(request, path);
    send_text(http::status::method_not_allowed, "method: is not served here\n");
  }

  // A browser that was given http:// for a port with TLS.
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
    response.set(http::field::cache_control, "no-cache");
    response.set(http::field::vary, "Accept-Encoding");
    if (!coding.empty()) response.set(http::field::content_encoding, std::string(coding));
    response.set("Content-Security-Policy", kContentSecurityPolicy);
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
    fetch_ = shared_.backend.fetch(hash, std::string(view_of(request["livegs-session"])), authorization);
    if (!fetch_) return send_text(http::status::not_found, "asset: is not an asset of the scene\n");
    const ContentCoding coding = choose_coding(view_of(request[http::field::accept_encoding]));
    stream_.expires_never();  // the work below has no timeout
    asio::post(shared_.pool, [self = shared_from_this(), hash, from, coding] {
      auto coded = self->shared_.assets.get(hash, self->fetch_->bytes(), from, coding);
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
  Bytes asset_;
  size_t asset_at_ = 0;
  std::optional<http::response<http::buffer_body>> asset_response_;
  std::optional<http::response_serializer<http::buffer_body>> asset_serializer_;
  asio::steady_timer timer_{shared_.io};
};

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
