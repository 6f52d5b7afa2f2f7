// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/chat/chat_reply.h"

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>

#include "analysis/model/chat/endpoint_quirks.h"
#include "analysis/model/chat/request_limits.h"
#include "analysis/model/chat/sse_parser.h"
#include "analysis/model/tool_box.h"
#include "server/analysis/model/chat/model_endpoint_cases.h"
#include "store/secret.h"

namespace livegs {
namespace {

TEST(SseParser, EventsDoNotDependOnChunking) {
  const std::string stream =
      "\xEF\xBB\xBF: ping\r\ndata: {\"a\":1}\r\n\r\nevent: x\rdata:two\rdata: lines\r\rid: "
      "7\n\ndata\n\ndata: "
      "\xC3\xA9\xE2\x82\xAC\n\ndata: [DONE]";
  const std::vector<std::string> expected = {"{\"a\":1}", "two\nlines", "", "\xC3\xA9\xE2\x82\xAC", "[DONE]"};
  for (std::size_t first = 0; first <= stream.size(); ++first) {
    for (std::size_t second = first; second <= stream.size(); second += 7) {
      SseParser parser;
      std::vector<std::string> events;
      for (const auto& piece :
           {stream.substr(0, first), stream.substr(first, second - first), stream.substr(second)}) {
        for (std::string& event : parser.feed(piece)) events.push_back(std::move(event));
      }
      for (std::string& event : parser.finish()) events.push_back(std::move(event));
      ASSERT_EQ(events, expected) << first << " " << second;
    }
  }
}

TEST(ChatReply, TruncatedStreamIsAnErrorOrTheAnswer) {
  const Reply whole = streams(streamed_answer(sound_answer()));
  const auto complete = decode_chat_reply(whole.body, true);
  ASSERT_TRUE(complete);
  EXPECT_EQ(complete->content, sound_answer());
  for (std::size_t size = 0; size < whole.body.size(); ++size) {
    const auto reply = decode_chat_reply(std::string_view(whole.body).substr(0, size), true);
    if (reply && !reply->error) {
      EXPECT_EQ(reply->content, sound_answer()) << size;
    }
  }
}

// Valid replies with truncated, duplicated, overwritten and spliced bytes. Decoding never crashes, and its
// result is bounded.
TEST(ChatReply, MutatedBytesGiveAValueOrAnError) {
  const std::vector<std::string> sound = {
      says(sound_answer()).body,
      calls({{"shell_mass", R"({"area_m2":1,"thickness_mm":1,"density_kg_m3":500})"},
             {"kb_get", R"({"id":"copper"})"}})
          .body,
      fails(429, {{"message", "m"}, {"code", "insufficient_quota"}, {"param", "temperature"}}).body,
      streams(streamed_answer(sound_answer())).body,
      R"({"object":"error","message":"x","code":400})",
      "```json\n" + sound_answer() + "\n```"};
  const std::vector<std::string> wanted = {"mass_g", "fill"};
  std::mt19937_64 random(20240601);
  const auto below = [&](std::size_t limit) {
    return static_cast<std::size_t>(random() % std::max<std::size_t>(limit, 1));
  };
  const char* tokens[] = {"{", "}", "[",       "]",    "\"",     "null", "1e999",  "-",
                          ":", ",", "\\u0000", "\xff", "data: ", "\n\n", "\\ud800"};
  const ToolBox tools;
  int understood = 0;
  for (int i = 0; i < 8000; ++i) {
    std::string text = sound[below(sound.size())];
    for (std::size_t change = 0, count = 1 + below(4); change < count; ++change) {
      const std::size_t at = below(text.size());
      switch (below(5)) {
        case 0:
          text.resize(at);
          break;
        case 1:
          text[std::min(at, text.size() - 1)] = static_cast<char>(random());
          break;
        case 2:
          text.insert(at, tokens[below(std::size(tokens))]);
          break;
        case 3:
          text.erase(at, below(40));
          break;
        default: {
          const std::string& other = sound[below(sound.size())];
          text.insert(at, other.substr(below(other.size()), below(200)));
        }
      }
      if (text.empty()) text = "x";
    }
    for (const bool events : {false, true}) {
      const auto reply = decode_chat_reply(text, events);
      if (!reply) continue;
      ++understood;
      EXPECT_LE(reply->tool_calls.size(), 32u);
      EXPECT_GE(reply->prompt_tokens, 0);
      for (const ToolCall& call : reply->tool_calls) (void)tools.call(call.name, call.arguments);
      if (reply->error) {
        EndpointQuirks quirks;
        (void)learn_from_refusal(quirks, *reply->error, {true, true, true, true, AnswerForm::JsonSchema},
                                 false);
      }
    }
    if (const auto object = find_json_object(text, wanted)) {
      EXPECT_TRUE(object->is_object());
    }
  }
  EXPECT_GT(understood, 400);  // the mutations are not only noise
}

TEST(EndpointQuirks, EveryRefusalDisablesAFeature) {
  const ServerError errors[] = {
      {"", "", "max_tokens", "use max_completion_tokens"},
      {"", "", "", ""},
      {"unsupported_value", "", "temperature", "temperature max_tokens tools schema"}};
  for (const ServerError& error : errors) {
    EndpointQuirks quirks;
    int steps = 0;
    for (;; ++steps) {
      RequestFeatures sent{quirks.tools, quirks.images, quirks.stream, quirks.web_search, quirks.form};
      const EndpointQuirks before = quirks;
      if (learn_from_refusal(quirks, error, sent, false).empty()) break;
      ASSERT_FALSE(before == quirks);
      ASSERT_LT(steps, 20);
    }
  }
}

TEST(CircuitBreaker, SingleProbeDecides) {
  CircuitBreaker breaker(2, 10.0);
  const std::int64_t second = 1000000000;
  breaker.fail(0, "down");
  EXPECT_TRUE(breaker.try_pass(0));
  breaker.fail(0, "down");
  EXPECT_FALSE(breaker.try_pass(9 * second));
  EXPECT_EQ(breaker.reason(), "down");
  EXPECT_TRUE(breaker.try_pass(10 * second));
  EXPECT_FALSE(breaker.try_pass(10 * second));  // one at a time
  breaker.fail(10 * second, "still down");
  EXPECT_FALSE(breaker.try_pass(19 * second));
  EXPECT_TRUE(breaker.try_pass(20 * second));
  breaker.succeed();
  EXPECT_FALSE(breaker.is_open());
  EXPECT_TRUE(breaker.try_pass(20 * second));
}

TEST(Backoff, DoublesUpToItsCapAndHonoursRetryAfter) {
  EXPECT_DOUBLE_EQ(backoff_s(0, 0.5, 8, 1.0, 0), 0.5);
  EXPECT_DOUBLE_EQ(backoff_s(3, 0.5, 8, 1.0, 0), 4.0);
  EXPECT_DOUBLE_EQ(backoff_s(10, 0.5, 8, 1.0, 0), 8.0);
  EXPECT_DOUBLE_EQ(backoff_s(100000, 0.5, 8, 0.25, 0), 2.0);
  EXPECT_DOUBLE_EQ(backoff_s(0, 0.5, 8, 0.1, 3.0), 3.0);
}

TEST(Secret, RedactsWholeAndPartialKeys) {
  const Secret key(kTestKey);
  EXPECT_EQ(key.redact("Bearer " + std::string(kTestKey) + "!"), "Bearer [key]!");
  EXPECT_EQ(key.redact("ends in 8pYc3NdHs"), "ends in [key]");
  EXPECT_EQ(key.redact("sk-live"), "sk-live");  // seven characters are below the redaction limit
  EXPECT_EQ(key.redact(""), "");
  EXPECT_EQ(Secret("none").redact("none of it"), "none of it");
  std::string text = "secret";
  wipe(text);
  EXPECT_TRUE(text.empty());
}

// libcurl's heap and the environment hold copies, so the process disables core files.
TEST(Secret, DisablesCoreFilesOfTheProcess) {
  const pid_t child = ::fork();
  if (child == 0) {
    rlimit most{};
    ::getrlimit(RLIMIT_CORE, &most);
    most.rlim_cur = most.rlim_max;
    ::setrlimit(RLIMIT_CORE, &most);
    ::prctl(PR_SET_DUMPABLE, 1);
    const Secret key(kTestKey);
    if (::prctl(PR_GET_DUMPABLE) != 0) ::_exit(1);
    ::raise(SIGQUIT);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_FALSE(WCOREDUMP(status));
}

// The flag dd in /proc/self/smaps marks a page as excluded from core files.
TEST(Secret, ExcludesItsPageFromCoreFiles) {
  const Secret key(kTestKey);
  char begin[32];
  std::snprintf(begin, sizeof begin, "%lx-", reinterpret_cast<unsigned long>(key.reveal().data()) & ~0xffful);
  std::ifstream smaps("/proc/self/smaps");
  bool inside = false, left_out = false;
  for (std::string line; std::getline(smaps, line);) {
    if (line.starts_with(begin)) inside = true;
    if (inside && line.starts_with("VmFlags:")) {
      left_out = line.find(" dd") != std::string::npos;
      break;
    }
  }
  if (!inside) GTEST_SKIP() << "the page is part of a larger mapping, or there is no /proc";
  EXPECT_TRUE(left_out);
}

}  // namespace
}  // namespace livegs
