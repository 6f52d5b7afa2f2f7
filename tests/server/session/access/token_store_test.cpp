// SPDX-License-Identifier: Apache-2.0
#include "session/access/token_store.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>

#include "scratch_folder.h"
#include "session/access/fleet_token.h"
#include "session/access/id_prefix.h"
#include "session/access/server_security.h"
#include "trust/fingerprint.h"
#include "trust/state_folder.h"

namespace livegs {
namespace {

constexpr int64_t kDay_s = 86400;

class Tokens : public ::testing::Test {
 protected:
  Tokens() { reopen(); }
  void reopen() {
    auto store = TokenStore::open(file_, [this] { return now_s_; });
    ASSERT_TRUE(store) << store.error().message;
    store_ = std::move(*store);
  }
  std::string why(const std::string& secret) const {
    const auto authorization = store_->check(secret);
    return authorization ? "" : authorization.error().message;
  }
  ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "tokens.json";
  int64_t now_s_ = 1'700'000'000;
  std::unique_ptr<TokenStore> store_;
};

TEST_F(Tokens, GrantTheirScopeOnly) {
  for (const v1::Scope scope : {v1::VIEW, v1::INTERACT, v1::AUTHOR, v1::ADMIN}) {
    const auto made = store_->add("headset", scope, 0);
    ASSERT_TRUE(made) << made.error().message;
    const auto authorization = store_->check(made->secret);
    ASSERT_TRUE(authorization) << authorization.error().message;
    EXPECT_EQ(authorization->token_id, made->token.id());
    for (const v1::Scope needed : {v1::VIEW, v1::INTERACT, v1::AUTHOR, v1::ADMIN})
      EXPECT_EQ(authorization->allows(needed), needed <= scope);
  }
}

// 256 bits at six bits per character.
TEST_F(Tokens, AreLongAndUnique) {
  std::vector<std::string> secrets;
  for (int i = 0; i < 50; ++i) secrets.push_back(store_->add("x", v1::VIEW, 1)->secret);
  std::sort(secrets.begin(), secrets.end());
  EXPECT_EQ(std::unique(secrets.begin(), secrets.end()), secrets.end());
  EXPECT_EQ(secrets[0].size(), 7u + 43u);
}

TEST_F(Tokens, NameTheProblemIfRefused) {
  const auto good = store_->add("good", v1::VIEW, 1), revoked = store_->add("lost", v1::VIEW, 1);
  ASSERT_TRUE(store_->revoke(revoked->token.id()));
  EXPECT_EQ(why(good->secret), "");
  EXPECT_NE(why("").find("token: is required"), std::string::npos);
  EXPECT_NE(why("livegs_something").find("not known to this server"), std::string::npos);
  EXPECT_NE(why(good->secret + "x").find("not known to this server"), std::string::npos);
  EXPECT_NE(why(good->secret.substr(1)).find("not known to this server"), std::string::npos);
  EXPECT_NE(why(revoked->secret).find("\"lost\": was revoked"), std::string::npos);
  now_s_ += kDay_s - 1;
  EXPECT_EQ(why(good->secret), "");
  EXPECT_TRUE(store_->check_still({good->token.id(), "good", v1::VIEW}));
  now_s_ += 1;
  EXPECT_NE(why(good->secret).find("\"good\": has expired"), std::string::npos);
  EXPECT_FALSE(store_->check_still({good->token.id(), "good", v1::VIEW}));
  EXPECT_FALSE(store_->check_still({"00000000", "never was", v1::VIEW}));
}

class FleetTokens : public Tokens {
 protected:
  FleetTokens() { store_->accept_fleet(key_, "room-a"); }
  std::string signed_for(const std::string& server, int64_t valid_s, const std::string& key) const {
    v1::FleetToken token;
    token.set_server(server);
    token.set_name("ada");
    token.set_scope(v1::INTERACT);
    token.set_expires_unix_s(now_s_ + valid_s);
    return *sign_fleet_token(key, token);
  }
  std::string cause(const std::string& text) const {
    const auto token = verify_fleet_token(key_, "room-a", text, now_s_);
    return token ? "" : token.error().message;
  }
  const std::string key_ = std::string(kMinFleetKeyBytes, 'k');
};

TEST_F(FleetTokens, GrantTheirScopeAndNameUntilTheyExpire) {
  const std::string text = signed_for("room-a", 60, key_);
  const auto authorization = store_->check(text);
  ASSERT_TRUE(authorization) << authorization.error().message;
  EXPECT_EQ(authorization->token_name, "ada");
  EXPECT_EQ(authorization->scope, v1::INTERACT);
  EXPECT_NE(authorization->token_id, store_->check(signed_for("room-a", 61, key_))->token_id);
  now_s_ += 59;
  EXPECT_TRUE(store_->check(text));
  EXPECT_TRUE(store_->check_still(*authorization));
  now_s_ += 1;
  EXPECT_FALSE(store_->check(text));
  EXPECT_FALSE(store_->check_still(*authorization));
  EXPECT_TRUE(store_->list().empty());
}

TEST_F(FleetTokens, AreRefusedForAnotherServerKeyOrTimeWithOneMessage) {
  const std::string other = signed_for("room-b", 60, key_), late = signed_for("room-a", -1, key_),
                    forged = signed_for("room-a", 60, std::string(kMinFleetKeyBytes, 'x'));
  EXPECT_NE(cause(other).find("is for server \"room-b\", not for \"room-a\""), std::string::npos)
      << cause(other);
  EXPECT_NE(cause(late).find("of \"ada\" has expired"), std::string::npos) << cause(late);
  EXPECT_NE(cause(forged).find("signature is wrong"), std::string::npos) << cause(forged);
  for (const std::string& text : {other, late, forged}) EXPECT_EQ(why(text), why("livegs_something"));
}

TEST_F(FleetTokens, AreRefusedAfterAnyChange) {
  const std::string text = signed_for("room-a", 60, key_);
  ASSERT_EQ(why(text), "");
  for (size_t i = 0; i < text.size(); ++i) {
    for (const char letter : {'A', 'B', 'w', '-', '.', '\0'}) {
      std::string altered = text;
      altered[i] = letter;
      if (altered != text) EXPECT_FALSE(store_->check(altered)) << i << letter;
    }
    EXPECT_FALSE(store_->check(text.substr(0, i))) << i;
    EXPECT_FALSE(store_->check(text.substr(i + 1))) << i;
  }
  EXPECT_FALSE(store_->check(text + "A"));
  EXPECT_FALSE(store_->check(text + "."));
  EXPECT_FALSE(store_->check("livegs_fleet_" + std::string(100'000, 'A') + "."));
}

// Signed contents that are not a token, as another program with the key could make.
TEST_F(FleetTokens, NeedReadableContents) {
  const std::string good = signed_for("room-a", 60, key_);
  v1::FleetToken token;
  token.set_server("room-a");
  token.set_name("ada");
  token.set_expires_unix_s(now_s_ + 60);
  EXPECT_FALSE(sign_fleet_token(key_, token));  // without a scope
  token.set_scope(v1::VIEW);
  token.set_name("a\nb");
  EXPECT_FALSE(sign_fleet_token(key_, token));
  token.set_name("ada");
  token.set_server("");
  EXPECT_FALSE(sign_fleet_token(key_, token));
}

TEST_F(FleetTokens, AreSignedForTheNextServerWithTheSameRights) {
  const auto here = store_->check(signed_for("room-a", 60, key_));
  const auto next = store_->fleet_token_for("room-b", *here);
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_EQ(why(*next), why("livegs_something"));
  const auto token = verify_fleet_token(key_, "room-b", *next, now_s_);
  ASSERT_TRUE(token) << token.error().message;
  EXPECT_EQ(token->name(), "ada");
  EXPECT_EQ(token->scope(), v1::INTERACT);
  EXPECT_EQ(token->expires_unix_s(), now_s_ + 60);
  const auto own = store_->add("headset", v1::ADMIN, 1);
  EXPECT_FALSE(store_->fleet_token_for("room-b", *store_->check(own->secret)));
}

TEST_F(Tokens, OfAFleetNeedItsKey) {
  v1::FleetToken token;
  token.set_server("");
  token.set_name("ada");
  token.set_scope(v1::ADMIN);
  token.set_expires_unix_s(now_s_ + 60);
  token.set_server("room");
  EXPECT_FALSE(store_->check(*sign_fleet_token("", token)));  // this server has none
}

TEST(FleetKey, IsRandomAndReadByItsOwnerOnly) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "fleet.key", second = folder / "second.key";
  ASSERT_TRUE(write_fleet_key(file));
  ASSERT_TRUE(write_fleet_key(second));
  EXPECT_FALSE(write_fleet_key(file));  // its tokens stay valid
  const auto key = read_fleet_key(file);
  ASSERT_TRUE(key) << key.error().message;
  EXPECT_GE(key->size(), kMinFleetKeyBytes);
  EXPECT_NE(*key, *read_fleet_key(second));
  ::chmod(file.c_str(), 0644);
  EXPECT_EQ(read_fleet_key(file).error().code, ErrorCode::PermissionDenied);
  EXPECT_EQ(read_fleet_key(folder.write("short.key", "secret\n")).error().code, ErrorCode::PermissionDenied);
  ::chmod((folder / "short.key").c_str(), 0600);
  EXPECT_EQ(read_fleet_key(folder / "short.key").error().code, ErrorCode::InvalidData);
}

TEST_F(Tokens, OutliveTheServerAndAreStoredAsHashes) {
  const auto made = store_->add("headset", v1::AUTHOR, 10), revoked = store_->add("lost", v1::VIEW, 10);
  ASSERT_TRUE(store_->revoke(revoked->token.id()));
  const std::string text = *read_secret_file(file_);
  EXPECT_EQ(text.find(made->secret), std::string::npos);
  EXPECT_EQ(text.find(made->secret.substr(7, 20)), std::string::npos);
  reopen();
  ASSERT_TRUE(store_->check(made->secret));
  EXPECT_EQ(store_->check(made->secret)->scope, v1::AUTHOR);
  EXPECT_NE(why(revoked->secret).find("revoked"), std::string::npos);
  for (const v1::Token& token : store_->list()) EXPECT_EQ(token.sha256(), "");
}

TEST_F(Tokens, AreRemovedAMonthAfterExpiry) {
  const auto old = store_->add("old", v1::VIEW, 1);
  now_s_ += 32 * kDay_s;
  ASSERT_TRUE(store_->add("new", v1::VIEW, 1));
  EXPECT_EQ(store_->list().size(), 1u);
  EXPECT_NE(why(old->secret).find("not known to this server"), std::string::npos);
}

TEST_F(Tokens, BadRequestsNameTheField) {
  const auto refused = [&](const std::string& name, v1::Scope scope, double days, const std::string& named) {
    const auto made = store_->add(name, scope, days);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().message.find(named), 0u) << made.error().message;
  };
  refused("", v1::VIEW, 1, "name:");
  refused(std::string(65, 'a'), v1::VIEW, 1, "name:");
  refused("line\nbreak", v1::VIEW, 1, "name:");
  refused("a", v1::SCOPE_UNSPECIFIED, 1, "scope:");
  refused("a", static_cast<v1::Scope>(5), 1, "scope:");
  for (const double days : {-1.0, 3651.0, std::nan(""), HUGE_VAL}) refused("a", v1::VIEW, days, "days:");
  EXPECT_FALSE(store_->revoke("00000000"));
  EXPECT_FALSE(store_->revoke("0"));
  EXPECT_TRUE(store_->list().empty());
}

TEST_F(Tokens, RefuseInvalidFilesByName) {
  for (const char* text : {"no json", "{\"tokens\": 3}", "{\"unknown\": 1}"}) {
    ASSERT_TRUE(write_secret_file(file_, text));
    const auto opened = TokenStore::open(file_);
    ASSERT_FALSE(opened) << text;
    EXPECT_EQ(opened.error().message.find(file_.string()), 0u) << opened.error().message;
  }
}

// If the file cannot be written, no token is created, but a revocation still applies.
TEST_F(Tokens, RevokeEvenIfTheFileCannotBeWritten) {
  const auto made = store_->add("a", v1::VIEW, 1);
  ASSERT_TRUE(made);
  std::filesystem::remove(file_);
  std::filesystem::create_directories(file_ /
                                      "in the way");  // rename() fails onto a folder that is not empty
  EXPECT_FALSE(store_->add("b", v1::VIEW, 1));
  EXPECT_EQ(store_->list().size(), 1u);
  EXPECT_FALSE(store_->revoke(made->token.id()));
  EXPECT_NE(why(made->secret).find("revoked"), std::string::npos);
}

unsigned mode_of(const std::filesystem::path& path) {
  struct stat about {};
  return ::stat(path.c_str(), &about) == 0 ? about.st_mode & 0777 : 0;
}

TEST(ServerSecurity, KeepsItsCertificateAndRenewsItsLocalToken) {
  const ScratchFolder folder;
  std::string fingerprint, token;
  {
    auto first = ServerSecurity::open(folder / "state");
    ASSERT_TRUE(first) << first.error().message;
    fingerprint = (*first)->fingerprint();
    EXPECT_EQ(*certificate_fingerprint((*first)->certificate_pem()), fingerprint);
    EXPECT_EQ(mode_of(folder / "state"), 0700u);
    for (const char* secret : {"server.key", "admin.token"})
      EXPECT_EQ(mode_of(folder / "state" / secret), 0600u);
    EXPECT_FALSE(find_local_server(folder / "state"));  // no port yet
    (*first)->set_port(4711);
    const auto found = find_local_server(folder / "state");
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->port, 4711);
    EXPECT_EQ(found->fingerprint, fingerprint);
    token = found->token;
    EXPECT_EQ((*first)->tokens().check(token)->scope, v1::ADMIN);
    const auto second = ServerSecurity::open(folder / "state");
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::Unavailable);
  }
  EXPECT_FALSE(find_local_server(folder / "state"));
  auto again = ServerSecurity::open(folder / "state");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ((*again)->fingerprint(), fingerprint);
  EXPECT_FALSE((*again)->tokens().check(token));
}

// `livegs ctl` finds a server whose certificate is not in its folder.
TEST(ServerSecurity, IsFoundWithACertificateOfItsOwn) {
  const ScratchFolder folder;
  const auto other = ServerSecurity::open(folder / "other");
  ASSERT_TRUE(other) << other.error().message;
  const auto server = ServerSecurity::open(
      folder / "state", system_wall_clock(),
      CertificateFiles{folder / "other" / "server.crt", folder / "other" / "server.key"});
  ASSERT_TRUE(server) << server.error().message;
  (*server)->set_port(4711);
  const auto found = find_local_server(folder / "state");
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->port, 4711);
  EXPECT_EQ(found->fingerprint, (*other)->fingerprint());
}

TEST(ServerSecurity, RefusesBadFilesByName) {
  const ScratchFolder folder;
  const std::filesystem::path state = folder / "state", other = folder / "other";
  ASSERT_TRUE(ServerSecurity::open(state));
  ASSERT_TRUE(ServerSecurity::open(other));
  ::chmod((state / "server.key").c_str(), 0644);
  auto opened = ServerSecurity::open(state);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("server.key: is readable by other users"), std::string::npos)
      << opened.error().message;
  std::filesystem::copy_file(other / "server.key", state / "server.key",
                             std::filesystem::copy_options::overwrite_existing);
  ::chmod((state / "server.key").c_str(), 0600);
  opened = ServerSecurity::open(state);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("do not match"), std::string::npos) << opened.error().message;
  folder.write("state/server.crt", "no certificate");
  EXPECT_FALSE(ServerSecurity::open(state));
  folder.write("file", "");
  EXPECT_FALSE(ServerSecurity::open(folder / "file"));
}

TEST_F(Tokens, RevokeTakesAUniqueBeginningOfTheId) {
  const auto made = store_->add("a", v1::VIEW, 1);
  ASSERT_TRUE(made);
  const std::string id = made->token.id();
  EXPECT_FALSE(store_->revoke(id.substr(0, 3)));  // too short, also if unique
  const auto revoked = store_->revoke(id.substr(0, 4));
  ASSERT_TRUE(revoked) << revoked.error().message;
  EXPECT_EQ(revoked->id(), id);
  EXPECT_NE(why(made->secret).find("revoked"), std::string::npos);
}

TEST(IdPrefix, MustBeLongEnoughAndUnique) {
  const std::vector<std::string> ids = {"abcd1", "abcd12", "ffff0"};
  const auto find = [&](const char* prefix) { return find_by_prefix(ids, prefix, "token", "livegs ctl"); };
  EXPECT_EQ(find("ffff").value(), 2u);
  EXPECT_EQ(find("abcd1").value(), 0u);  // a whole id is preferred
  EXPECT_EQ(find("abcd12").value(), 1u);
  EXPECT_EQ(find("fff").error().message, "token: id is too short; give four or more digits");
  EXPECT_EQ(find("abcd").error().message, "token: several ids start with \"abcd\"; give more digits");
  EXPECT_EQ(find("zzzz").error().message, "token: no id starts with \"zzzz\"; run livegs ctl to list them");
}

}  // namespace
}  // namespace livegs
