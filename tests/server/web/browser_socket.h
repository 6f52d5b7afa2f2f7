// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <string>

#include "patience.h"

// A browser's side of HTTP/1.1 and WebSocket, byte by byte, for tests.

namespace livegs {

struct WebReply {
  int status = 0;  // 0: no answer
  std::map<std::string, std::string> headers;
  std::string body;
};

inline std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// A connection whose bytes the test controls.
class Wire {
 public:
  explicit Wire(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{std::chrono::duration_cast<std::chrono::seconds>(kPatience).count(), 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  }
  ~Wire() { ::close(socket_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  bool send(const std::string& bytes) const {
    return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  // Exactly `count` bytes; fewer if the connection ends.
  std::string read(size_t count) {
    while (waiting_.size() < count && fill()) {
    }
    std::string taken = waiting_.substr(0, count);
    waiting_.erase(0, taken.size());
    return taken;
  }
  std::string read_until(const std::string& end) {
    size_t at = std::string::npos;
    while ((at = waiting_.find(end)) == std::string::npos && fill()) {
    }
    return at == std::string::npos ? read(waiting_.size()) : read(at + end.size());
  }

  WebReply answer(bool with_body = true) {
    WebReply answer;
    const std::string head = read_until("\r\n\r\n");
    if (head.size() < 12 || !head.starts_with("HTTP/1.1 ")) return answer;
    answer.status = std::stoi(head.substr(9, 3));
    for (size_t at = head.find("\r\n") + 2; at + 2 < head.size();) {
      const size_t end = head.find("\r\n", at), colon = head.find(": ", at);
      if (colon < end)
        answer.headers[lower(head.substr(at, colon - at))] = head.substr(colon + 2, end - colon - 2);
      at = end + 2;
    }
    if (with_body && answer.headers.contains("content-length"))
      answer.body = read(std::stoul(answer.headers["content-length"]));
    return answer;
  }

 private:
  bool fill() {
    char bytes[4096];
    const ssize_t got = ::recv(socket_, bytes, sizeof bytes, 0);
    if (got > 0) waiting_.append(bytes, static_cast<size_t>(got));
    return got > 0;
  }
  int socket_;
  std::string waiting_;
};

inline std::string request(const std::string& method, const std::string& target, const std::string& body = "",
                           const std::string& headers = "", const std::string& host = "127.0.0.1") {
  return method + " " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + headers +
         (body.empty() ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n") + "\r\n" + body;
}

// The WebSocket of RFC 6455, from the side of the browser.
class BrowserSocket {
 public:
  explicit BrowserSocket(int port, const std::string& headers = "") : wire_(port) {
    wire_.send(
        request("GET", "/stream", "",
                "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: livegs.v1\r\n" +
                    headers));
    upgrade = wire_.answer();
  }
  WebReply upgrade;

  bool send(const std::string& message, uint8_t opcode = 2) {
    std::string frame(1, static_cast<char>(0x80 | opcode));
    if (message.size() < 126) {
      frame += static_cast<char>(0x80 | message.size());
    } else {
      frame += static_cast<char>(0x80 | 126);
      frame += static_cast<char>(message.size() >> 8);
      frame += static_cast<char>(message.size());
    }
    const std::string mask = "\x11\x22\x33\x44";
    frame += mask;
    for (size_t i = 0; i < message.size(); ++i) frame += static_cast<char>(message[i] ^ mask[i % 4]);
    return wire_.send(frame);
  }
  struct Message {
    int opcode = -1;  // -1: the connection has ended
    std::string bytes;
  };
  Message read() {
    Message message;
    do {
      const std::string head = wire_.read(2);
      if (head.size() < 2) return {};
      message.opcode = head[0] & 15;
      size_t length = static_cast<uint8_t>(head[1]) & 127;
      if (length >= 126) {
        const std::string wide = wire_.read(length == 126 ? 2 : 8);
        length = 0;
        for (const char c : wide) length = length << 8 | static_cast<uint8_t>(c);
      }
      message.bytes = wire_.read(length);
    } while (message.opcode == 9);  // a ping
    return message;
  }

 private:
  Wire wire_;
};

}  // namespace livegs
