// SPDX-License-Identifier: Apache-2.0
#include "store/object_store.h"

#include <gtest/gtest.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "core/clock.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "object_store_mock.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

constexpr StoreTimes kShort{.patience_s = 0.6, .stall_s = 0.3};

std::string some_bytes(size_t count) {
  std::string bytes(count, '\0');
  uint32_t state = 1;
  for (char& byte : bytes) byte = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
  return bytes;
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string hash_of(const std::string& bytes) { return content_hash(std::as_bytes(std::span(bytes))); }

std::shared_ptr<ObjectStore> opened(const std::string& place, const StoreTimes& times = kShort) {
  auto store = ObjectStore::open(place, times);
  EXPECT_TRUE(store) << (store ? "" : store.error().message);
  return *store;
}

Reply status(int code) {
  Reply reply;
  reply.status = code;
  reply.body = "refused";
  return reply;
}

// Environment variables of one test.
class Variables {
 public:
  explicit Variables(const std::map<std::string, std::string>& values) {
    for (const auto& [name, value] : values) {
      names_.push_back(name);
      ::setenv(name.c_str(), value.c_str(), 1);
    }
  }
  ~Variables() {
    for (const std::string& name : names_) ::unsetenv(name.c_str());
  }

 private:
  std::vector<std::string> names_;
};

TEST(ObjectStore, FolderAndHttpKeepTheSameObjects) {
  const ScratchFolder folder;
  ObjectStoreMock mock;
  const std::string bytes = some_bytes(300'000);
  for (const std::string& place : {(folder / "store").string(), mock.url() + "/rooms/a/"}) {
    const auto store = opened(place);
    EXPECT_EQ(store->size("x/one").value(), std::nullopt);
    EXPECT_EQ(store->get("x/one").error().code, ErrorCode::NotFound);
    ASSERT_TRUE(store->put("x/one", std::as_bytes(std::span(bytes))));
    EXPECT_EQ(store->size("x/one").value(), bytes.size());
    EXPECT_EQ(text_of(store->get("x/one").value()), bytes);
    ASSERT_TRUE(store->put("x/one", {}));
    EXPECT_EQ(store->get("x/one").value().size(), 0u);
    ASSERT_TRUE(store->put_file("x/two", folder.write("two", bytes)));
    EXPECT_EQ(store->hash("x/two").value(), hash_of(bytes));
    ASSERT_TRUE(store->put_file("x/two", folder.write("two", "")));
    EXPECT_EQ(store->size("x/two").value(), 0u);
    EXPECT_EQ(store->put_file("x/two", folder / "absent").error().code, ErrorCode::NotFound);
  }
}

TEST(ObjectStore, ReadsFromAnOffset) {
  const ScratchFolder folder;
  ObjectStoreMock mock, without_ranges;
  without_ranges.ignore_ranges();
  const std::string bytes = some_bytes(100'000);
  folder.write("one", bytes);
  mock.set("one", bytes);
  without_ranges.set("one", bytes);
  for (const std::string& place : {folder.path().string(), mock.url(), without_ranges.url()}) {
    const auto store = opened(place);
    for (const uint64_t from : {uint64_t{1}, uint64_t{99'999}, uint64_t{100'000}}) {
      std::string got;
      const auto done = store->read("one", from, [&](uint64_t offset, std::span<const std::byte> piece) {
        EXPECT_EQ(offset, from + got.size());
        got += text_of(piece);
        return Result<void>();
      });
      ASSERT_TRUE(done) << place << done.error().message;
      EXPECT_EQ(got, bytes.substr(from)) << place;
    }
    EXPECT_FALSE(
        store->read("one", 100'001, [](uint64_t, std::span<const std::byte>) { return Result<void>(); }));
  }
  EXPECT_EQ(mock.sent_bytes(), 99'999u + 1);
}

// The transfer is cut again and again: the bytes are correct, and none is fetched twice.
TEST(ObjectStore, ResumesACutTransfer) {
  ObjectStoreMock mock;
  const std::string bytes = some_bytes(200'000);
  mock.set("one", bytes);
  size_t given = 0;
  mock.set_fault([&](const SeenRequest&, int index) -> std::optional<Reply> {
    if (index >= 4) return std::nullopt;
    Reply cut;
    cut.body = bytes.substr(given);
    cut.cut_after = 30'000;
    if (given > 0) {
      cut.status = 206;
      cut.headers.push_back("Content-Range: bytes " + std::to_string(given) + "-199999/200000");
    }
    given += cut.cut_after;
    return cut;
  });
  EXPECT_EQ(text_of(opened(mock.url())->get("one").value()), bytes);
  EXPECT_EQ(mock.requests().size(), 5u);
  EXPECT_EQ(mock.sent_bytes(), bytes.size() - 120'000);
}

TEST(ObjectStore, WaitsForASlowStoreButNotForASilentOne) {
  ObjectStoreMock mock;
  const std::string bytes = some_bytes(8'000);
  mock.set("slow", bytes);
  mock.set_fault([&](const SeenRequest& request, int) -> std::optional<Reply> {
    Reply reply;
    reply.body = bytes;
    if (request.path == "/slow") {
      reply.piece_bytes = 500;
      reply.piece_delay_ms = 60;
    } else {
      reply.hang = true;
      reply.cut_after = 100;
    }
    return reply;
  });
  const auto store = opened(mock.url());
  EXPECT_EQ(text_of(store->get("slow").value()), bytes);  // takes longer than the patience in all
  const auto silent = store->get("silent");
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::Unavailable);
  EXPECT_NE(silent.error().message.find("/silent: the reply stalled"), std::string::npos)
      << silent.error().message;
}

TEST(ObjectStore, RepeatsWhatMayPassAndReportsWhatDoesNot) {
  ObjectStoreMock mock;
  mock.set("one", "bytes");
  const auto store = opened(mock.url());
  for (const int passing : {408, 429, 500, 502, 503, 504}) {
    mock.set_fault([&](const SeenRequest&, int index) -> std::optional<Reply> {
      if (index >= 2) return std::nullopt;
      return status(passing);
    });
    EXPECT_EQ(text_of(store->get("one").value()), "bytes") << passing;
  }
  const std::vector<std::pair<int, ErrorCode>> kinds{
      {401, ErrorCode::PermissionDenied}, {403, ErrorCode::PermissionDenied},
      {404, ErrorCode::NotFound},         {410, ErrorCode::NotFound},
      {301, ErrorCode::InvalidArgument},  {400, ErrorCode::InvalidArgument},
      {503, ErrorCode::Unavailable}};
  for (const auto& [code, kind] : kinds) {
    int asked = 0;
    mock.set_fault([&](const SeenRequest&, int index) -> std::optional<Reply> {
      asked = index + 1;
      return status(code);
    });
    const auto refused = store->get("one");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, kind) << code;
    EXPECT_EQ(refused.error().message.find(mock.url() + "/one: "), 0u) << refused.error().message;
    EXPECT_EQ(asked > 1, code == 503) << code;
    mock.set_fault({});
  }
  const auto with_code = [](int code, const std::string& name) {
    Reply reply = status(code);
    reply.body = "<?xml version=\"1.0\"?><Error><Code>" + name + "</Code><Message>m</Message></Error>";
    return reply;
  };
  const auto twice_late = [&](const SeenRequest&, int index) -> std::optional<Reply> {
    if (index >= 2) return std::nullopt;
    return with_code(400, "RequestTimeout");
  };
  mock.set_fault(twice_late);
  EXPECT_EQ(text_of(store->get("one").value()), "bytes");
  mock.set_fault(twice_late);
  EXPECT_TRUE(store->put("two", std::as_bytes(std::span("bytes"))));
  // Temporary for a job, which may get other keys, but not for this process.
  int asked = 0;
  mock.set_fault([&](const SeenRequest&, int) {
    ++asked;
    return with_code(400, "ExpiredToken");
  });
  const auto expired = store->get("one");
  ASSERT_FALSE(expired);
  EXPECT_EQ(expired.error().code, ErrorCode::Unavailable);
  EXPECT_EQ(asked, 1);
  const std::vector<std::pair<std::string, std::string>> shown{
      {"AccessDenied", "status 403 (AccessDenied); "},
      {"a b\n<>", "status 403; "},
      {std::string(1000, 'x'), "status 403; "}};
  for (const auto& [name, text] : shown) {
    mock.set_fault([&](const SeenRequest&, int) { return with_code(403, name); });
    const auto refused = store->get("one");
    EXPECT_NE(refused.error().message.find(text), std::string::npos) << refused.error().message;
  }
  const auto nowhere = opened("http://127.0.0.1:1")->get("one");
  EXPECT_EQ(nowhere.error().code, ErrorCode::Unavailable);
}

// A presigned address is valid for GET only, and the reply to HEAD has no body.
TEST(ObjectStore, SizeOfAStoreThatRefusesHead) {
  ObjectStoreMock mock;
  mock.set("one", std::string(20'000'000, 'x'));
  mock.set("empty", "");
  const auto store = opened(mock.url());
  for (const int refusal : {400, 403, 405}) {
    mock.set_fault([&](const SeenRequest& request, int) -> std::optional<Reply> {
      if (request.method == "HEAD") return status(refusal);
      return std::nullopt;
    });
    EXPECT_EQ(store->size("one").value(), 20'000'000u) << refusal;
    EXPECT_EQ(store->size("empty").value(), 0u) << refusal;
    EXPECT_EQ(store->size("two").value(), std::nullopt) << refusal;
  }
  const std::vector<std::tuple<std::string, int, ErrorCode>> causes{
      {"ExpiredToken", 400, ErrorCode::Unavailable}, {"AccessDenied", 403, ErrorCode::PermissionDenied}};
  for (const auto& [cause, code, kind] : causes) {
    int asked = 0;
    mock.set_fault([&](const SeenRequest& request, int) -> std::optional<Reply> {
      ++asked;
      Reply reply = status(code);
      if (request.method != "HEAD") reply.body = "<Error><Code>" + cause + "</Code></Error>";
      return reply;
    });
    const auto size = store->size("one");
    ASSERT_FALSE(size);
    EXPECT_EQ(size.error().code, kind) << cause;
    EXPECT_NE(size.error().message.find("(" + cause + ")"), std::string::npos) << size.error().message;
    EXPECT_EQ(asked, 2) << cause;
  }
}

TEST(ObjectStore, RefusesOtherBytesThanTheHash) {
  ObjectStoreMock mock;
  const std::string good = some_bytes(5'000), hash = hash_of(good);
  mock.set(hash, good);
  const auto store = opened(mock.url());
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "file";
  ASSERT_TRUE(store->read_to_file_by_hash(hash, file));
  EXPECT_EQ(read_text_file(file).value(), good);
  mock.set_fault([&](const SeenRequest&, int index) -> std::optional<Reply> {  // a damaged copy, once
    Reply reply;
    reply.body = some_bytes(4'000);
    if (index > 0) return std::nullopt;
    return reply;
  });
  ASSERT_TRUE(store->read_to_file_by_hash(hash, file));
  EXPECT_EQ(read_text_file(file).value(), good);
  mock.set_fault({});
  mock.set(hash, good.substr(1));
  const auto refused = store->read_to_file_by_hash(hash, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::InvalidData);
}

// The object is replaced after the first cut: with or without If-Range, no byte of the first version stays.
TEST(ObjectStore, AChangedObjectIsReadFromItsBeginning) {
  const std::string before = some_bytes(50'000), longer = some_bytes(70'000).substr(1);
  const std::string shorter(100, 'x'), same_size = std::string(30'000, 'y') + before.substr(30'000);
  for (const std::string& after : {longer, shorter, same_size}) {
    for (const bool knows_versions : {true, false}) {
      ObjectStoreMock mock;
      if (!knows_versions) mock.ignore_versions();
      mock.set("one", after);
      mock.set_fault([&](const SeenRequest&, int index) -> std::optional<Reply> {
        if (index > 0) return std::nullopt;
        Reply cut;
        cut.body = before;
        cut.cut_after = 20'000;
        cut.headers.push_back("ETag: " + ObjectStoreMock::etag_of(before));
        return cut;
      });
      const auto store = opened(mock.url());
      EXPECT_EQ(text_of(store->get("one").value()), after);
      EXPECT_NE(mock.requests()[1].head.find("If-Range: " + ObjectStoreMock::etag_of(before)),
                std::string::npos);
      EXPECT_EQ(mock.requests().size(), knows_versions ? 2u : 3u);
      mock.set_fault({});
      EXPECT_EQ(store->hash("one").value(), hash_of(after));
    }
  }
}

TEST(ObjectStore, AnObjectThatAlwaysChangesIsNotRead) {
  ObjectStoreMock mock;
  const std::string bytes = some_bytes(1000);
  mock.set_fault([&](const SeenRequest&, int index) {
    Reply cut;
    cut.body = bytes;
    cut.cut_after = 500;
    cut.headers.push_back("ETag: \"" + std::to_string(index) + '"');
    return std::optional<Reply>(cut);
  });
  const auto refused = opened(mock.url())->get("one");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::Unavailable);
  EXPECT_NE(refused.error().message.find("/one: changes while it is read"), std::string::npos)
      << refused.error().message;
}

// The time in which bytes are sent is no part of the patience.
TEST(ObjectStore, RepeatsAnUploadThatTakesLongerThanThePatience) {
  constexpr StoreTimes kTimes{.patience_s = 1, .stall_s = 5};
  ObjectStoreMock mock;
  mock.receive_slowly(4);
  const std::string bytes = some_bytes(24'000'000);
  mock.set_fault([&](const SeenRequest&, int index) -> std::optional<Reply> {
    if (index >= 1) return std::nullopt;
    return status(503);
  });
  const int64_t begun_ns = now_ns();
  const auto done = opened(mock.url(), kTimes)->put("one", std::as_bytes(std::span(bytes)));
  EXPECT_TRUE(done) << (done ? "" : done.error().message);
  EXPECT_GT(seconds_from_ns(now_ns() - begun_ns), 2 * kTimes.patience_s);
  EXPECT_TRUE(mock.get("one") == bytes);
  EXPECT_EQ(mock.requests().size(), 2u);
}

TEST(ObjectStore, EndsWhenItIsStopped) {
  ObjectStoreMock mock;
  mock.set_fault([](const SeenRequest&, int) {
    Reply reply;
    reply.hang = true;
    reply.cut_after = 0;
    return std::optional<Reply>(reply);
  });
  const auto store = opened(mock.url(), {.patience_s = 60, .stall_s = 60});
  std::stop_source stop;
  std::jthread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop.request_stop();
  });
  const int64_t begun_ns = now_ns();
  EXPECT_EQ(store->get("one", kMaxObjectBytes, stop.get_token()).error().code, ErrorCode::Unavailable);
  EXPECT_LT(seconds_from_ns(now_ns() - begun_ns), 20);
}

TEST(ObjectStore, RefusesWhatIsNoPlace) {
  for (const char* place :
       {"", "http://", "https:///x", "s3://", "s3:///x", "ftp://host/x", "http://host/x?key=1"})
    EXPECT_EQ(ObjectStore::open(place).error().code, ErrorCode::InvalidArgument) << place;
  for (const char* place : {"http://host", "http://host/", "folder/"})
    EXPECT_EQ(open_object(place).error().code, ErrorCode::InvalidArgument) << place;
}

TEST(ObjectStore, MessagesHoldNoKeys) {
  EXPECT_EQ(shown_url("https://user:pass@host/a?X-Amz-Signature=ab"), "https://host/a");
  ObjectStoreMock mock;
  const auto place = open_object(mock.url() + "/one.zip?X-Amz-Signature=secret-key", kShort);
  ASSERT_TRUE(place);
  const auto refused = place->store->get(place->name);
  EXPECT_EQ(refused.error().message, mock.url() + "/one.zip: does not exist in the store");
  EXPECT_EQ(mock.requests().front().path, "/one.zip?X-Amz-Signature=secret-key");
}

// ---- Signatures, computed here by the text of AWS's specification.

std::string hmac(const std::string& key, const std::string& text) {
  unsigned char digest[32];
  unsigned int size = sizeof digest;
  HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
       reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest, &size);
  return {reinterpret_cast<char*>(digest), size};
}

std::map<std::string, std::string> headers_of(const SeenRequest& request) {
  std::map<std::string, std::string> all;
  std::istringstream lines(request.head);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    if (line.ends_with('\r')) line.pop_back();
    const size_t colon = line.find(": ");
    if (colon == std::string::npos) continue;
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    all[name] = line.substr(colon + 2);
  }
  return all;
}

// The signature that the request should have.
std::string signature_of(const SeenRequest& request, const std::string& secret, const std::string& region) {
  auto headers = headers_of(request);
  const std::string authorization = headers["authorization"], date = headers["x-amz-date"];
  const size_t at = authorization.find("SignedHeaders=") + 14;
  const std::string signed_names = authorization.substr(at, authorization.find(',', at) - at);
  std::string canonical = request.method + "\n" + request.path + "\n\n";
  std::istringstream names(signed_names);
  for (std::string name; std::getline(names, name, ';');) canonical += name + ":" + headers[name] + "\n";
  canonical += "\n" + signed_names + "\n" + headers["x-amz-content-sha256"];
  const std::string scope = date.substr(0, 8) + "/" + region + "/s3/aws4_request";
  const std::string text = "AWS4-HMAC-SHA256\n" + date + "\n" + scope + "\n" + hash_of(canonical);
  const std::string key =
      hmac(hmac(hmac(hmac("AWS4" + secret, date.substr(0, 8)), region), "s3"), "aws4_request");
  const std::string digest = hmac(key, text);
  return hexadecimal(std::as_bytes(std::span(digest)));
}

TEST(ObjectStore, SignsRequestsToABucket) {
  ObjectStoreMock mock;
  const Variables variables({{"AWS_ENDPOINT_URL", mock.url()},
                             {"AWS_REGION", "eu-west-3"},
                             {"AWS_ACCESS_KEY_ID", "AKIDEXAMPLE"},
                             {"AWS_SECRET_ACCESS_KEY", "wJalrXUtnFEMI-K7MDENG"},
                             {"AWS_SESSION_TOKEN", "session-token"}});
  const auto store = opened("s3://rooms/museum");
  const std::string bytes = some_bytes(70'000);
  ASSERT_TRUE(store->put("hall.ply", std::as_bytes(std::span(bytes))));
  EXPECT_EQ(mock.names(), std::vector<std::string>{"rooms/museum/hall.ply"});
  EXPECT_EQ(text_of(store->get("hall.ply").value()), bytes);
  EXPECT_EQ(store->size("hall.ply").value(), bytes.size());
  ASSERT_TRUE(
      store->read("hall.ply", 9, [](uint64_t, std::span<const std::byte>) { return Result<void>(); }));
  ASSERT_EQ(mock.requests().size(), 4u);
  for (const SeenRequest& request : mock.requests()) {
    auto headers = headers_of(request);
    EXPECT_EQ(headers["x-amz-security-token"], "session-token");
    EXPECT_EQ(headers["x-amz-content-sha256"], hash_of(request.body));
    const std::string authorization = headers["authorization"];
    EXPECT_NE(authorization.find("Credential=AKIDEXAMPLE/"), std::string::npos) << request.head;
    EXPECT_NE(authorization.find("x-amz-content-sha256;x-amz-date;x-amz-security-token"), std::string::npos)
        << authorization;
    EXPECT_EQ(authorization.substr(authorization.find("Signature=") + 10),
              signature_of(request, "wJalrXUtnFEMI-K7MDENG", "eu-west-3"))
        << request.head;
  }
}

TEST(ObjectStore, BucketsNeedBothKeysOrNone) {
  ObjectStoreMock mock;
  mock.set("rooms/one", "bytes");
  const Variables variables({{"AWS_ENDPOINT_URL", mock.url()}});
  EXPECT_EQ(text_of(opened("s3://rooms")->get("one").value()), "bytes");
  EXPECT_EQ(mock.requests().front().head.find("Authorization"), std::string::npos);
  const Variables half({{"AWS_ACCESS_KEY_ID", "AKIDEXAMPLE"}});
  EXPECT_EQ(ObjectStore::open("s3://rooms").error().code, ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace livegs
