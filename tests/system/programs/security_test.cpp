// SPDX-License-Identifier: Apache-2.0
// TLS, pairing, tokens and `livegs ctl`, tested with the programs.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "system/programs/programs_fixture.h"

namespace livegs {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

size_t count_of(const std::string& what, const std::string& text) {
  size_t count = 0;
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++count;
  return count;
}

class SecurePrograms : public Programs {
 protected:
  std::vector<std::string> secure_server(const std::string& state = "state", const std::string& port = "0") {
    return {LIVEGS_SERVER,
            folder_.write("boxes.scene.json", kBoxesScene),
            "--listen",
            "127.0.0.1:" + port,
            "--tls",
            "on",
            "--state-dir",
            folder_ / state,
            "--print-port",
            "--threads",
            "1",
            "--verbose"};
  }
  std::vector<std::string> ctl_words(const std::string& port, std::vector<std::string> more,
                                     const std::string& state = "state") {
    std::vector<std::string> words = {LIVEGS_TOOL,         "ctl",         "--server",
                                      "127.0.0.1:" + port, "--state-dir", folder_ / state};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::string ctl(const std::string& port, std::vector<std::string> more,
                  const std::string& state = "state") {
    Program program(ctl_words(port, std::move(more), state));
    EXPECT_EQ(program.wait(), 0) << program.err();
    said_ += program.err();
    return program.out();
  }
  // Creates a token and writes it to a file of that name. Returns the token.
  std::string make_token(const std::string& port, const std::string& name, const std::string& scope,
                         const std::string& days = "90") {
    const std::string token = ctl(port, {"tokens", "add", name, "--scope", scope, "--days", days});
    folder_.write(name, token);
    return token.substr(0, token.find('\n'));
  }
  std::string token_id(const std::string& port, const std::string& name) {
    std::istringstream lines(ctl(port, {"tokens", "list"}));
    for (std::string line; std::getline(lines, line);) {
      if (line.find(" " + name + " ") != std::string::npos) return line.substr(0, 8);
    }
    return "";
  }
  std::string pairing_code(const std::string& port, const std::string& state = "state") {
    const std::string status = ctl(port, {"status"}, state);
    const size_t begun = status.find("pairing code  ");
    return begun == std::string::npos ? "" : status.substr(begun + 14, 29);
  }
  std::vector<std::string> viewer(const std::string& port, std::vector<std::string> more,
                                  const std::string& state = "pins", const std::string& seconds = "0.3") {
    std::vector<std::string> words =
        client_words(port, {"--seconds", seconds, "--no-video", "--verbose", "--connect-timeout", "20",
                            "--state-dir", folder_ / state});
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  // Expects an immediate end with code 1 and only this message.
  void expect_refused(std::vector<std::string> words, const std::string& answer) {
    words.erase(std::find(words.begin(), words.end(), "--verbose"));
    Program client(std::move(words));
    EXPECT_EQ(client.wait(), 1);
    expect_one_line(client, answer);
    said_ += client.err();
  }
  std::string said_;  // output of ended programs
};

TEST_F(SecurePrograms, ErrorsDifferPerFaultAndAValidClientJoins) {
  Program server(secure_server());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const std::string good = make_token(port, "good", "interact"), lost = make_token(port, "lost", "view");
  ctl(port, {"tokens", "revoke", token_id(port, "lost")});
  folder_.write("wrong", "livegs_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA\n");
  const std::string code = pairing_code(port);
  ASSERT_EQ(code.size(), 29u);

  expect_refused(viewer(port, {"--pair", code}), "token: is required");
  expect_refused(viewer(port, {"--pair", code, "--token-file", folder_ / "wrong"}),
                 "not known to this server");
  expect_refused(viewer(port, {"--pair", code, "--token-file", folder_ / "lost"}), "\"lost\": was revoked");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "pins"));  // no pin was stored
  std::string other = code;
  other[0] = other[0] == 'A' ? 'B' : 'A';
  expect_refused(viewer(port, {"--pair", other, "--token-file", folder_ / "good"}),
                 "does not match the pairing code");

  Program first(viewer(port, {"--pair", code, "--token-file", folder_ / "good", "--poke", "box"}));
  EXPECT_EQ(first.wait(), 0) << first.err();
  Program second(viewer(port, {}));  // the pin is stored now
  EXPECT_EQ(second.wait(), 0) << second.err();
  EXPECT_EQ(
      std::filesystem::status(folder_ / "pins" / "known_servers").permissions() & std::filesystem::perms::all,
      std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);

  EXPECT_NE(ctl(port, {"health"}).find("serving"), std::string::npos);
  EXPECT_EQ(ctl(port, {"status", "--json"}).find(good), std::string::npos);
  ctl(port, {"drain", "--reason", "the test is over"});
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_NE(server.err().find("the test is over"), std::string::npos);

  // No secret is printed by any program in a whole session at the most verbose log level.
  const std::string key = text_of(folder_ / "state" / "server.key");
  for (const std::string& text :
       {server.err() + server.out(), first.err() + first.out(), second.err() + second.out(), said_}) {
    for (const std::string& secret :
         {good, lost, good.substr(10, 16), lost.substr(10, 16), key.substr(40, 60)})
      EXPECT_EQ(text.find(secret), std::string::npos);
  }
  EXPECT_EQ(text_of(folder_ / "state" / "tokens.json").find(good), std::string::npos);
}

TEST_F(SecurePrograms, RefusesADifferentServerBeforeSending) {
  std::string port;
  {
    Program server(secure_server());
    port = server.first_line();
    ASSERT_NE(port, "") << server.err();
    make_token(port, "good", "view");
    Program client(viewer(port, {"--pair", pairing_code(port), "--token-file", folder_ / "good"}));
    ASSERT_EQ(client.wait(), 0) << client.err();
  }
  Program impostor(secure_server("other state", port));
  ASSERT_NE(impostor.first_line(), "") << impostor.err();
  expect_refused(viewer(port, {}), "certificate differs from the paired one");
  EXPECT_EQ(impostor.err().find("joined"), std::string::npos);
  EXPECT_NE(ctl(port, {"status"}, "other state").find(" 0 sessions in total"), std::string::npos);
}

// The certificate is stored, so clients reconnect after a server restart. A token that was revoked in between
// is refused.
TEST_F(SecurePrograms, RestartKeepsPairingAndTokens) {
  std::string port;
  auto words = secure_server();
  {
    Program server(words);
    port = server.first_line();
    ASSERT_NE(port, "") << server.err();
    make_token(port, "good", "interact");
    Program client(viewer(port, {"--pair", pairing_code(port), "--token-file", folder_ / "good"}));
    ASSERT_EQ(client.wait(), 0) << client.err();
    server.send(SIGKILL);
    server.wait();
  }
  Program again(secure_server("state", port));
  ASSERT_NE(again.first_line(), "") << again.err();
  Program client(viewer(port, {"--reconnect", "60"}, "pins", "0"));
  ASSERT_TRUE(again.says("streaming to")) << again.err();
  EXPECT_NE(ctl(port, {"clients"}).find("streaming"), std::string::npos);
  ctl(port, {"tokens", "revoke", token_id(port, "good")});
  EXPECT_EQ(client.wait(), 1) << client.err();
  EXPECT_NE(client.err().find("\"good\": was revoked"), std::string::npos) << client.err();
  // The client does not reconnect for this error. On a busy machine, it does after one second without data.
  EXPECT_EQ(count_of("; reconnecting", client.err()),
            count_of("no message for 1 s; reconnecting", client.err()))
      << client.err();
}

// During a stream and afterwards, the client gets the error of the token at once, and no other message.
TEST_F(SecurePrograms, ExpiredTokenEndsItsStream) {
  Program server(secure_server());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  make_token(port, "good", "interact");
  const std::string code = pairing_code(port);
  make_token(port, "guest", "view", "0.0003");  // 0.0003 days = 26 s
  auto words = viewer(port, {"--pair", code, "--token-file", folder_ / "guest", "--reconnect", "60"},
                      "guest's pins", "0");
  words.erase(std::find(words.begin(), words.end(), "--verbose"));
  Program guest(words);
  ASSERT_TRUE(server.says("streaming to")) << server.err() << guest.err();
  Program host(viewer(port, {"--pair", code, "--token-file", folder_ / "good"}, "pins", "0"));
  EXPECT_EQ(guest.wait(), 1) << guest.err();
  const std::string err = guest.err(),
                    answer = "token \"guest\": has expired; ask the server's operator for a new one";
  EXPECT_NE(err.find(answer), std::string::npos) << err;
  EXPECT_EQ(err.find(answer), err.rfind(answer)) << err;
  EXPECT_EQ(count_of("; reconnecting", err), count_of("no message for 1 s; reconnecting", err)) << err;
  for (const char* state : {"guest's pins", "nobody's pins"})
    expect_refused(viewer(port, {"--pair", code, "--token-file", folder_ / "guest"}, state), answer);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "nobody's pins"));
  EXPECT_NE(ctl(port, {"tokens", "list"}).find("expired"), std::string::npos);
  // Other clients were not disturbed.
  ASSERT_TRUE(server.says_often("streaming to", 2)) << server.err();
  host.send(SIGINT);
  EXPECT_EQ(host.wait(), 0) << host.err();
}

TEST_F(SecurePrograms, RemoteClientsNeedTlsAndTokens) {
  auto words = server_words({"--tls", "off"});
  std::replace(words.begin(), words.end(), std::string("127.0.0.1:0"), std::string("0.0.0.0:0"));
  Program clear(words);
  EXPECT_EQ(clear.wait(), 2);
  expect_one_line(clear, "--listen 0.0.0.0:0: needs TLS and tokens");

  folder_.write("file", "");
  words.resize(words.size() - 2);
  words.insert(words.end(), {"--state-dir", folder_ / "file/state"});
  Program keyless(words);
  EXPECT_EQ(keyless.wait(), 2);
  expect_one_line(keyless, "cannot be created");

  words.back() = folder_ / "state";
  Program secure(words);
  const std::string port = secure.first_line();
  ASSERT_NE(port, "") << secure.err();
  EXPECT_NE(secure.err().find("--pair " + pairing_code(port)), std::string::npos) << secure.err();
  // The commands are on lines of their own, to be copied.
  EXPECT_NE(secure.err().find(":" + port + " --pair " + pairing_code(port) + " --token-file client.token\n"),
            std::string::npos)
      << secure.err();
  EXPECT_NE(secure.err().find("\n  livegs ctl --server 127.0.0.1:" + port + " --state-dir '" +
                              (folder_ / "state").string() + "' tokens add client > client.token\n"),
            std::string::npos)
      << secure.err();

  auto far = viewer("9780", {});
  std::replace(far.begin(), far.end(), std::string("127.0.0.1:9780"), std::string("192.0.2.1:9780"));
  far.erase(std::find(far.begin(), far.end(), "--verbose"));
  Program unpaired(far);
  EXPECT_EQ(unpaired.wait(), 2);
  expect_one_line(unpaired, "pair with --pair CODE");
}

TEST_F(SecurePrograms, CtlWorksWithoutTls) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  EXPECT_NE(ctl(port, {"status"}).find("unencrypted"), std::string::npos);
  EXPECT_NE(ctl(port, {"status", "--json"}).find("\"secure\": false"), std::string::npos);
  EXPECT_EQ(ctl(port, {"health", "--json"}), "{\"serving\": true}\n");
  Program tokens(ctl_words(port, {"tokens", "list"}));
  EXPECT_EQ(tokens.wait(), 1);
  expect_one_line(tokens, "--tls on");
  Program client(client_words(port, {"--seconds", "0", "--no-video", "--every", "0", "--reconnect", "60"}));
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  ASSERT_TRUE(client.says("first picture: ")) << client.err();  // while the stream continues
  EXPECT_TRUE(std::filesystem::exists(folder_ / "view" / "first.png"));
  std::istringstream lines(ctl(port, {"clients"}));
  std::string head, row;
  std::getline(lines, head);
  std::getline(lines, row);
  ctl(port, {"kick", row.substr(0, 8), "--reason", "lunch"});
  EXPECT_EQ(client.wait(), 1);
  const size_t reason = client.err().find("ended by the server's operator: lunch");
  EXPECT_NE(reason, std::string::npos) << client.err();
  EXPECT_LT(reason, client.err().find("stream ended after")) << client.err();  // npos if all is drawn
  EXPECT_NE(client.out().find("drawn: 2 pictures"), std::string::npos) << client.out();
  ctl(port, {"drain"});
  EXPECT_EQ(server.wait(), 0) << server.err();
  Program gone(ctl_words(port, {"health"}));
  EXPECT_EQ(gone.wait(), 1);
  expect_one_line(gone, "server does not answer");
}

TEST_F(SecurePrograms, TlsServerWithoutPairingIsNamedAsThat) {
  Program server(secure_server());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  expect_refused(viewer(port, {}), "a server answers with TLS; pair with --pair CODE");
  expect_refused(viewer(port, {"--subscribe", "tcp://127.0.0.1:1"}),
                 "a server answers with TLS; pair with --pair CODE");
  Program stranger(ctl_words(port, {"status"}, "another state"));
  EXPECT_EQ(stranger.wait(), 1);
  expect_one_line(stranger, "is not the server of this state directory");
  EXPECT_NE(stranger.err().find("--state-dir"), std::string::npos) << stranger.err();
}

TEST(Ctl, ReportsUnknownCommands) {
  const auto says = [](std::vector<std::string> words) {
    words.insert(words.begin(), LIVEGS_TOOL);
    Program program(words);
    EXPECT_EQ(program.wait(), 2);
    return program.err();
  };
  EXPECT_EQ(says({"ctl", "--server", "127.0.0.1:1", "frob"}),
            "livegs ctl: unknown command \"frob\"; available: status, clients, kick, health, drain, record, "
            "replay, link, tokens\n");
  EXPECT_EQ(says({"ctl", "record", "pause"}),
            "livegs ctl record: unknown command \"pause\"; available: start, stop\n");
  EXPECT_EQ(says({"frob"}).find("livegs: unknown command \"frob\"; available: info, "), 0u);
}

}  // namespace
}  // namespace livegs
