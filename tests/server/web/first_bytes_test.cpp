// SPDX-License-Identifier: Apache-2.0
#include "web/first_bytes.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace livegs {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(const std::string& text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

void put(Bytes& bytes, size_t value, size_t width) {
  for (size_t i = width; i-- > 0;) bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
}

void put_block(Bytes& bytes, const Bytes& content, size_t width) {
  put(bytes, content.size(), width);
  bytes.insert(bytes.end(), content.begin(), content.end());
}

// A ClientHello in one record, written by hand from RFC 8446 and RFC 7301. `padding`: bytes of an extension
// before ALPN, as a post-quantum key share.
Bytes client_hello(const std::vector<std::string>& protocols, size_t padding = 0) {
  Bytes extensions;
  if (padding > 0) {
    put(extensions, 51, 2);
    put_block(extensions, Bytes(padding), 2);
  }
  if (!protocols.empty()) {
    Bytes names, list;
    for (const std::string& one : protocols) put_block(names, bytes_of(one), 1);
    put_block(list, names, 2);
    put(extensions, 16, 2);
    put_block(extensions, list, 2);
  }
  Bytes hello;
  put(hello, 0x0303, 2);
  hello.resize(hello.size() + 32);
  put_block(hello, Bytes(32), 1);
  put_block(hello, Bytes(6), 2);
  put_block(hello, Bytes(1), 1);
  put_block(hello, extensions, 2);
  Bytes handshake;
  put(handshake, 1, 1);
  put_block(handshake, hello, 3);
  Bytes record;
  put(record, 22, 1);
  put(record, 0x0301, 2);
  put_block(record, handshake, 2);
  return record;
}

TEST(FirstBytes, AreDividedByAlpn) {
  EXPECT_EQ(first_protocol(client_hello({"grpc-exp", "h2"})), FirstProtocol::Grpc);
  EXPECT_EQ(first_protocol(client_hello({"h2", "http/1.1"})), FirstProtocol::WebTls);
  EXPECT_EQ(first_protocol(client_hello({"http/1.1"})), FirstProtocol::WebTls);
  EXPECT_EQ(first_protocol(client_hello({})), FirstProtocol::WebTls);
  EXPECT_EQ(first_protocol(client_hello({"h2", "http/1.1"}, 1900)), FirstProtocol::WebTls);
  EXPECT_EQ(first_protocol(client_hello({"h2"}, 1900)), FirstProtocol::Grpc);
}

TEST(FirstBytes, AreDividedInTheClear) {
  EXPECT_EQ(first_protocol(bytes_of("PRI * HTTP/2.0\r\n")), FirstProtocol::Grpc);
  EXPECT_EQ(first_protocol(bytes_of("GET / HTTP/1.1\r\n")), FirstProtocol::Web);
  EXPECT_EQ(first_protocol(bytes_of("POST /pair HTTP/1.1\r\n")), FirstProtocol::Web);
  EXPECT_EQ(first_protocol(bytes_of("nonsense")), FirstProtocol::Grpc);
}

// Every beginning is undecided or has the answer of the whole, so that the pieces in which bytes arrive do
// not matter.
TEST(FirstBytes, WaitForWhatIsMissing) {
  for (const Bytes& whole : {client_hello({"h2", "http/1.1"}, 700), client_hello({"grpc-exp", "h2"}),
                             bytes_of("GET / HTTP/1.1\r\n"), bytes_of("PRI * HTTP/2.0\r\n")}) {
    const FirstProtocol answer = first_protocol(whole);
    for (size_t size = 0; size < whole.size(); ++size) {
      const FirstProtocol part = first_protocol(std::span(whole).first(size));
      EXPECT_TRUE(part == FirstProtocol::Undecided || part == answer) << size;
    }
  }
}

TEST(FirstBytes, MayBeAnything) {
  std::mt19937 random(7);
  const Bytes hello = client_hello({"h2", "http/1.1"}, 40);
  for (int i = 0; i < 200'000; ++i) {
    Bytes bytes = hello;
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    bytes.resize(random() % (bytes.size() + 1));
    (void)first_protocol(bytes);
  }
}

}  // namespace
}  // namespace livegs
