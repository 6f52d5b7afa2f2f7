// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "web/web_shared.h"

// Internal to web_server.cpp.

namespace livegs::web {

// Codes of a closing WebSocket: this plus the status code of gRPC (RFC 6455, section 7.4.2: 4000 to 4999 are
// private).
inline constexpr int kFirstCloseCode = 4000;
inline constexpr size_t kMaxCloseReason = 120;  // RFC 6455, section 5.5: 123 bytes

// Connects a WebSocket to a Stream RPC. Each message of one side is one message of the other. At most one
// message is in transit in each direction, so a slow browser throttles the server as a slow gRPC client does.
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
  bool writing_ = false;                // a message is in transit to the call
  bool writing_ended_ = false, reading_ended_ = false, ended_ = false;
};

}  // namespace livegs::web
