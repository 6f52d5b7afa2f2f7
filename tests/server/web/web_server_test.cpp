// SPDX-License-Identifier: Apache-2.0
// Browsers at the port of gRPC: the page, assets, calls, the stream as a WebSocket, and what is refused.
#include "web/web_server.h"

#include <curl/curl.h>
#include <map>
#include <thread>

#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"
#include "patience.h"
#include "scratch_folder.h"
#include "server/session/rpc/grpc_server_fixture.h"
#include "server/web/browser_socket.h"
#include "session/access/server_security.h"
#include "web/page_files.h"

namespace livegs {
namespace {

class WebServerTest : public GrpcServerTest {
 protected:
  WebReply ask(const std::string& text) {
    Wire wire(server_->port());
    wire.send(text);
    return wire.answer();
  }
  v1::JoinReply join() {
    v1::JoinRequest wish;
    wish.set_protocol_version(kProtocolVersion);
    wish.set_client_name("a browser");
    const WebReply answer = ask(request("POST", "/livegs.v1.LiveGs/Join", wish.SerializeAsString()));
    EXPECT_EQ(answer.status, 200) << answer.body;
    v1::JoinReply reply;
    EXPECT_TRUE(reply.ParseFromString(answer.body));
    return reply;
  }
};

TEST_F(WebServerTest, ServesThePage) {
  open();
  const WebReply page = ask(request("GET", "/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, find_page_file("/")->bytes);
  EXPECT_NE(page.headers.at("content-security-policy").find("default-src 'self'"), std::string::npos);
  EXPECT_EQ(page.headers.at("cross-origin-embedder-policy"), "require-corp");
  EXPECT_EQ(page.headers.at("cache-control"), "no-store");
  for (const PageFile& file : page_files()) {
    if (!file.named_by_content()) continue;
    EXPECT_EQ(ask(request("GET", std::string(file.path))).headers["cache-control"],
              "public, max-age=31536000, immutable")
        << file.path;
  }
  const WebReply known = ask(request("GET", "/", "", "If-None-Match: " + page.headers.at("etag") + "\r\n"));
  EXPECT_EQ(known.status, 304);
  const WebReply coded = ask(request("GET", "/", "", "Accept-Encoding: br, gzip\r\n"));
  EXPECT_EQ(coded.headers.at("content-encoding"), "br");
  EXPECT_EQ(ask(request("GET", "/nothing")).status, 404);
  EXPECT_EQ(ask(request("DELETE", "/")).status, 0);  // no method of browsers: the door gives it to gRPC
}

TEST_F(WebServerTest, ServesCallsOnOneConnection) {
  open();
  Wire wire(server_->port());
  for (int i = 0; i < 3; ++i) {
    wire.send(request("POST", "/livegs.v1.LiveGs/GetServerInfo"));
    const WebReply answer = wire.answer();
    v1::ServerInfo info;
    ASSERT_TRUE(answer.status == 200 && info.ParseFromString(answer.body)) << answer.status;
    EXPECT_EQ(info.protocol_version(), kProtocolVersion);
  }
  wire.send(request("POST", "/livegs.v1.LiveGs/AnalyzeObject"));
  const WebReply refused = wire.answer();
  EXPECT_NE(refused.status, 200);
  EXPECT_FALSE(refused.headers.at("grpc-status").empty());
  EXPECT_FALSE(refused.body.empty());
}

TEST_F(WebServerTest, ServesAssetsThatStoreTheirBlocks) {
  open();
  const v1::JoinReply joined = join();
  ASSERT_GT(joined.objects_size(), 0);
  const std::string hash = joined.objects(0).asset_hash();
  const WebReply whole = ask(request("GET", "/assets/" + hash));
  ASSERT_EQ(whole.status, 200);
  EXPECT_EQ(whole.headers.at("livegs-total-bytes"), std::to_string(whole.body.size()));
  const auto bytes = std::as_bytes(std::span(whole.body));
  const auto asset = decode_progressive(bytes);
  ASSERT_TRUE(asset) << asset.error().message;
  EXPECT_EQ(asset->size(), joined.objects(0).kernel_count());
  const WebReply rest = ask(request("GET", "/assets/" + hash + "?from=100"));
  EXPECT_EQ(rest.body, whole.body.substr(100));
  EXPECT_EQ(
      ask(request("GET", "/assets/" + hash, "", "Accept-Encoding: zstd\r\n")).headers.at("content-encoding"),
      "zstd");
  EXPECT_EQ(ask(request("GET", "/assets/" + hash + "?from=9999999999")).status, 400);
  EXPECT_EQ(ask(request("GET", "/assets/" + hash + "?from=x")).status, 400);
  EXPECT_EQ(ask(request("GET", "/assets/0")).status, 404);
}

// A browser that has an asset fetches another one as an edit of it.
TEST_F(WebServerTest, ServesEditsThatStoreTheirBlocks) {
  open();
  const v1::JoinReply joined = join();
  ASSERT_GT(joined.objects_size(), 0);
  const std::string first = joined.objects(0).asset_hash();
  const WebReply whole = ask(request("GET", "/assets/" + first));
  auto decoded = decode_progressive(std::as_bytes(std::span(whole.body)));
  ASSERT_TRUE(decoded);
  const auto base = std::make_shared<GaussianAsset>(*std::move(decoded));
  const auto asset = std::make_shared<GaussianAsset>(*base);
  asset->resize(asset->size() - 100);
  const std::string second = content_hash(encode_ply(*asset)), path = "/assets/" + second + "?base=" + first;
  TickResult changed = tick(1);
  changed.changed = {scene_.objects().front()};
  changed.changed.front().asset = asset;
  server_->ticks().publish(std::move(changed));
  WebReply edit;
  for (const auto until = std::chrono::steady_clock::now() + kPatience;
       edit.status != 200 && std::chrono::steady_clock::now() < until;)
    edit = ask(request("GET", path));
  ASSERT_EQ(edit.status, 200);
  EXPECT_LT(edit.body.size(), 200u);
  ProgressiveDecoder decoder(base);
  ASSERT_TRUE(decoder.take(std::as_bytes(std::span(edit.body))));
  const auto made = decoder.whole();
  ASSERT_TRUE(made);
  EXPECT_EQ(encode_ply(*made), encode_ply(*asset));
  EXPECT_GT(ask(request("GET", "/assets/" + second)).body.size(), 10'000u) << "the whole asset";
  EXPECT_EQ(ask(request("GET", "/assets/" + second + "?base=0")).status, 404);
  EXPECT_EQ(ask(request("GET", "/assets/" + first + "?base=" + second)).status, 404);
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
  EXPECT_EQ(ask(request("GET", "/livegs-view.js", "", evil)).status, 403);
  EXPECT_NE(ask(request("GET", "/")).headers["content-security-policy"].find("frame-ancestors 'none'"),
            std::string::npos);
  // Another name that leads to this address.
  EXPECT_EQ(ask(request("GET", "/", "", "", "evil.example")).status, 403);
  EXPECT_EQ(
      ask(request("POST", "/livegs.v1.LiveGs/GetServerInfo", "", "Origin: http://127.0.0.1\r\n")).status,
      200);
  EXPECT_EQ(ask(request("GET", "/", "", "", "localhost:9780")).status, 200);
}

// <livegs-view>: a listed site may load its module and show the page in a frame, and nothing else.
TEST_F(WebServerTest, LetsListedSitesShowTheScene) {
  const std::string listed = "Origin: https://example.org\r\n", evil = "Origin: https://evil.example\r\n";
  server_->allow_origins({"https://example.org"});
  open();
  WebReply module = ask(request("GET", "/livegs-view.js", "", listed));
  EXPECT_EQ(module.status, 200);
  EXPECT_EQ(module.headers["access-control-allow-origin"], "https://example.org");
  EXPECT_EQ(module.headers["cross-origin-resource-policy"], "cross-origin");
  EXPECT_NE(
      ask(request("GET", "/")).headers["content-security-policy"].find("frame-ancestors https://example.org"),
      std::string::npos);
  EXPECT_EQ(ask(request("GET", "/livegs-view.js", "", evil)).status, 403);
  EXPECT_EQ(ask(request("POST", "/livegs.v1.LiveGs/GetServerInfo", "", listed)).status, 403);
  EXPECT_EQ(ask(request("GET", "/assets/0", "", listed)).status, 403);
  EXPECT_EQ(ask(request("GET", "/", "", listed)).status, 403);
  EXPECT_EQ(BrowserSocket(server_->port(), listed).upgrade.status, 403);
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
  WebReply ask(const std::string& path, const std::string& post = "",
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
    WebReply answer;
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
  WebReply call(const std::string& method, const std::string& token) {
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
  const WebReply revoked = call("GetServerInfo", viewer->secret);
  EXPECT_EQ(revoked.status, 401);
  EXPECT_NE(revoked.body.find("revoked"), std::string::npos) << revoked.body;
}

TEST_F(SecureWebTest, PairsABrowserOnce) {
  const v1::BrowserLink link = server_->new_browser_link();
  ASSERT_EQ(link.urls_size(), 1);
  EXPECT_EQ(link.urls(0), "https://127.0.0.1:" + std::to_string(server_->port()) + "/#pair=" + link.code());
  EXPECT_EQ(ask("/pair", "AAAAAAAA").status, 401);
  const WebReply paired = ask("/pair", link.code());
  ASSERT_EQ(paired.status, 200);
  EXPECT_EQ(call("GetServerInfo", paired.body).status, 200);
  EXPECT_EQ(call("ControlRun", paired.body).status, 403) << "a browser may touch, not author";
  EXPECT_EQ(ask("/pair", link.code()).status, 401);
}

TEST_F(SecureWebTest, LeadsFromHttpToHttps) {
  const WebReply answer = ask("/page", "", {}, "http");
  EXPECT_EQ(answer.status, 308);
}

}  // namespace
}  // namespace livegs
