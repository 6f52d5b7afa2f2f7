// SPDX-License-Identifier: Apache-2.0
// Browsers at the port of gRPC: the page, assets, calls, the stream as a WebSocket, and what is refused.
#include "web/web_server.h"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <map>
#include <thread>

#include "gaussian/progressive_asset.h"
#include "patience.h"
#include "scratch_folder.h"
#include "server/session/rpc/grpc_server_fixture.h"
#include "session/access/server_security.h"
#include "web/page_files.h"

namespace livegs {
namespace {

struct Answer {
  int status = 0;  // 0: no answer
  std::map<std::string, std::string> headers;
  std::string body;
};

std::string lower(std::string text) {
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

  Answer answer(bool with_body = true) {
    Answer answer;
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

std::string request(const std::string& method, const std::string& target, const std::string& body = "",
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
  Answer upgrade;

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

class WebServerTest : public GrpcServerTest {
 protected:
  Answer ask(const std::string& text) {
    Wire wire(server_->port());
    wire.send(text);
    return wire.answer();
  }
  v1::JoinReply join() {
    v1::JoinRequest wish;
    wish.set_protocol_version(kProtocolVersion);
    wish.set_client_name("a browser");
    const Answer answer = ask(request("POST", "/livegs.v1.LiveGs/Join", wish.SerializeAsString()));
    EXPECT_EQ(answer.status, 200) << answer.body;
    v1::JoinReply reply;
    EXPECT_TRUE(reply.ParseFromString(answer.body));
    return reply;
  }
};

TEST_F(WebServerTest, ServesThePage) {
  open();
  const Answer page = ask(request("GET", "/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, find_page_file("/")->bytes);
  EXPECT_NE(page.headers.at("content-security-policy").find("default-src 'self'"), std::string::npos);
  EXPECT_EQ(page.headers.at("cross-origin-embedder-policy"), "require-corp");
  const Answer known = ask(request("GET", "/", "", "If-None-Match: " + page.headers.at("etag") + "\r\n"));
  EXPECT_EQ(known.status, 304);
  const Answer coded = ask(request("GET", "/", "", "Accept-Encoding: br, gzip\r\n"));
  EXPECT_EQ(coded.headers.at("content-encoding"), "br");
  EXPECT_EQ(ask(request("GET", "/nothing")).status, 404);
  EXPECT_EQ(ask(request("DELETE", "/")).status, 0);  // no method of browsers: the door gives it to gRPC
}

TEST_F(WebServerTest, ServesCallsOnOneConnection) {
  open();
  Wire wire(server_->port());
  for (int i = 0; i < 3; ++i) {
    wire.send(request("POST", "/livegs.v1.LiveGs/GetServerInfo"));
    const Answer answer = wire.answer();
    v1::ServerInfo info;
    ASSERT_TRUE(answer.status == 200 && info.ParseFromString(answer.body)) << answer.status;
    EXPECT_EQ(info.protocol_version(), kProtocolVersion);
  }
  wire.send(request("POST", "/livegs.v1.LiveGs/AnalyzeObject"));
  const Answer refused = wire.answer();
  EXPECT_NE(refused.status, 200);
  EXPECT_FALSE(refused.headers.at("grpc-status").empty());
  EXPECT_FALSE(refused.body.empty());
}

TEST_F(WebServerTest, ServesAssetsThatStoreTheirBlocks) {
  open();
  const v1::JoinReply joined = join();
  ASSERT_GT(joined.objects_size(), 0);
  const std::string hash = joined.objects(0).asset_hash();
  const Answer whole = ask(request("GET", "/assets/" + hash));
  ASSERT_EQ(whole.status, 200);
  EXPECT_EQ(whole.headers.at("livegs-total-bytes"), std::to_string(whole.body.size()));
  const auto bytes = std::as_bytes(std::span(whole.body));
  const auto asset = decode_progressive(bytes);
  ASSERT_TRUE(asset) << asset.error().message;
  EXPECT_EQ(asset->size(), joined.objects(0).kernel_count());
  const Answer rest = ask(request("GET", "/assets/" + hash + "?from=100"));
  EXPECT_EQ(rest.body, whole.body.substr(100));
  EXPECT_EQ(
      ask(request("GET", "/assets/" + hash, "", "Accept-Encoding: zstd\r\n")).headers.at("content-encoding"),
      "zstd");
  EXPECT_EQ(ask(request("GET", "/assets/" + hash + "?from=9999999999")).status, 400);
  EXPECT_EQ(ask(request("GET", "/assets/" + hash + "?from=x")).status, 400);
  EXPECT_EQ(ask(request("GET", "/assets/0")).status, 404);
}

// The frames of a WebSocket have the bytes that a gRPC client receives.
TEST_F(WebServerTest, StreamsTheBytesOfGrpc) {
  open();
  RawClient native(server_->port());
  ASSERT_TRUE(native.join().ok());
  native.open();
  const v1::JoinReply joined = join();
  BrowserSocket browser(server_->port());
  ASSERT_EQ(browser.upgrade.status, 101);
  EXPECT_EQ(browser.upgrade.headers.at("sec-websocket-protocol"), "livegs.v1");
  v1::ClientMessage hello;
  hello.set_session_id(joined.session_id());
  ASSERT_TRUE(browser.send(hello.SerializeAsString()));
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (server_->streaming_count() < 2 && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ASSERT_EQ(server_->streaming_count(), 2u);
  int compared = 0;
  for (uint64_t number = 1; number <= 20; ++number) {
    publish(number);
    v1::ServerMessage ours, theirs;
    do {
      const BrowserSocket::Message message = browser.read();
      ASSERT_EQ(message.opcode, 2);
      ASSERT_TRUE(ours.ParseFromString(message.bytes));
    } while (ours.frame().empty() || ours.tick() < number);
    do {
      theirs = native.read();
    } while (theirs.frame().empty() || theirs.tick() < number);
    EXPECT_EQ(ours.frame(), theirs.frame()) << number;
    ++compared;
    native.acknowledge(number);
    v1::ClientMessage read;
    read.set_acknowledged_tick(number);
    ASSERT_TRUE(browser.send(read.SerializeAsString()));
  }
  EXPECT_EQ(compared, 20);
  // The end of the stream is the end of the socket, with the status of the call.
  server_->shut_down("maintenance");
  BrowserSocket::Message last;
  while ((last = browser.read()).opcode == 2) {
  }
  EXPECT_EQ(last.opcode, 8);
  ASSERT_GE(last.bytes.size(), 2u);
  const int code = static_cast<uint8_t>(last.bytes[0]) << 8 | static_cast<uint8_t>(last.bytes[1]);
  EXPECT_EQ(code, 4000 + grpc::StatusCode::UNAVAILABLE) << last.bytes.substr(2);
}

TEST_F(WebServerTest, EndsAStreamThatSendsNonsense) {
  open();
  BrowserSocket browser(server_->port());
  ASSERT_EQ(browser.upgrade.status, 101);
  ASSERT_TRUE(browser.send("nonsense"));
  EXPECT_EQ(browser.read().opcode, 8);
  BrowserSocket large(server_->port());
  ASSERT_TRUE(large.send(std::string(65'000, 'x')));
  EXPECT_EQ(large.read().opcode, 8);
}

TEST_F(WebServerTest, RefusesPagesOfOtherSites) {
  open();
  const std::string evil = "Origin: http://evil.example\r\n";
  EXPECT_EQ(ask(request("POST", "/livegs.v1.LiveGs/GetServerInfo", "", evil)).status, 403);
  EXPECT_EQ(BrowserSocket(server_->port(), evil).upgrade.status, 403);
  // Another name that leads to this address.
  EXPECT_EQ(ask(request("GET", "/", "", "", "evil.example")).status, 403);
  EXPECT_EQ(
      ask(request("POST", "/livegs.v1.LiveGs/GetServerInfo", "", "Origin: http://127.0.0.1\r\n")).status,
      200);
  EXPECT_EQ(ask(request("GET", "/", "", "", "localhost:9780")).status, 200);
}

TEST_F(WebServerTest, RefusesLargeAndSlowRequests) {
  open();
  EXPECT_NE(ask(request("GET", "/" + std::string(2 * kMaxWebHeaderBytes, 'x'))).status, 200);
  EXPECT_EQ(
      ask(request("POST", "/livegs.v1.LiveGs/GetServerInfo", std::string(kMaxWebBodyBytes + 1, 'x'))).status,
      413);
  Wire slow(server_->port());
  slow.send("GET / HTTP/1.1\r\nHost: 127.0");
  EXPECT_EQ(slow.read(1), "");
  EXPECT_EQ(ask(request("GET", "/")).status, 200);
}

// With TLS and tokens, by an independent client.
class SecureWebTest : public ::testing::Test {
 protected:
  SecureWebTest() : scene_(box_scene()) {
    security_ = std::move(*ServerSecurity::open(folder_ / "state"));
    server_ = std::move(*GrpcServer::listen("127.0.0.1:0", security_.get()));
    server_->open(scene_, inputs_);
  }
  Answer ask(const std::string& path, const std::string& post = "",
             const std::vector<std::string>& headers = {}, const std::string& scheme = "https") {
    CURL* const curl = curl_easy_init();
    const std::string url = scheme + "://127.0.0.1:" + std::to_string(server_->port()) + path;
    curl_easy_setopt(curl, CURLOPT_URL, url.c_str());
    curl_easy_setopt(curl, CURLOPT_NOPROXY, "*");
    curl_easy_setopt(curl, CURLOPT_SSL_VERIFYPEER, 0L);
    curl_easy_setopt(curl, CURLOPT_SSL_VERIFYHOST, 0L);
    curl_easy_setopt(curl, CURLOPT_TIMEOUT, 30L);
    if (!post.empty()) {
      curl_easy_setopt(curl, CURLOPT_POSTFIELDS, post.data());
      curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE, static_cast<long>(post.size()));
    }
    curl_slist* list = nullptr;
    for (const std::string& one : headers) list = curl_slist_append(list, one.c_str());
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, list);
    Answer answer;
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &answer.body);
    curl_easy_setopt(
        curl, CURLOPT_WRITEFUNCTION, +[](char* bytes, size_t size, size_t count, std::string* body) {
          body->append(bytes, size * count);
          return size * count;
        });
    if (curl_easy_perform(curl) == CURLE_OK) {
      long status = 0;
      curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
      answer.status = static_cast<int>(status);
    }
    curl_slist_free_all(list);
    curl_easy_cleanup(curl);
    return answer;
  }
  Answer call(const std::string& method, const std::string& token) {
    // A request of one unknown field, so that the body is not empty.
    return ask("/livegs.v1.LiveGs/" + method, std::string("\xf8\x01\x01", 3),
               token.empty() ? std::vector<std::string>()
                             : std::vector<std::string>{"Authorization: Bearer " + token});
  }

  ScratchFolder folder_;
  Scene scene_;
  InputLog inputs_;
  std::unique_ptr<ServerSecurity> security_;
  std::unique_ptr<GrpcServer> server_;
};

TEST_F(SecureWebTest, NeedsATokenForAllButThePage) {
  EXPECT_EQ(ask("/").status, 200);
  EXPECT_EQ(call("GetServerInfo", "").status, 401);
  EXPECT_EQ(call("GetServerInfo", "wrong").status, 401);
  EXPECT_EQ(ask("/assets/0").status, 401);
  const auto viewer = security_->tokens().add("viewer", v1::VIEW, 1);
  EXPECT_EQ(call("GetServerInfo", viewer->secret).status, 200);
  EXPECT_EQ(call("ControlRun", viewer->secret).status, 403);
  EXPECT_EQ(call("ApplyForce", viewer->secret).status, 403);
  (void)security_->tokens().revoke(viewer->token.id());
  const Answer revoked = call("GetServerInfo", viewer->secret);
  EXPECT_EQ(revoked.status, 401);
  EXPECT_NE(revoked.body.find("revoked"), std::string::npos) << revoked.body;
}

TEST_F(SecureWebTest, PairsABrowserOnce) {
  const v1::BrowserLink link = server_->new_browser_link();
  ASSERT_EQ(link.urls_size(), 1);
  EXPECT_EQ(link.urls(0), "https://127.0.0.1:" + std::to_string(server_->port()) + "/#pair=" + link.code());
  EXPECT_EQ(ask("/pair", "AAAAAAAA").status, 401);
  const Answer paired = ask("/pair", link.code());
  ASSERT_EQ(paired.status, 200);
  EXPECT_EQ(call("GetServerInfo", paired.body).status, 200);
  EXPECT_EQ(call("ControlRun", paired.body).status, 403) << "a browser may touch, not author";
  EXPECT_EQ(ask("/pair", link.code()).status, 401);
}

TEST_F(SecureWebTest, LeadsFromHttpToHttps) {
  const Answer answer = ask("/page", "", {}, "http");
  EXPECT_EQ(answer.status, 308);
}

}  // namespace
}  // namespace livegs
