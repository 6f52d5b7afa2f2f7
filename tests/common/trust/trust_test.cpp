// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scratch_folder.h"
#include "trust/fingerprint.h"
#include "trust/host_port.h"
#include "trust/known_servers.h"
#include "trust/server_access.h"
#include "trust/server_probe.h"
#include "trust/state_folder.h"

namespace livegs {
namespace {

// SHA-256 of a certificate, and its first 125 bits in Crockford's base 32, computed independently.
const std::string kFingerprint = "63efb4062f43850618aa400a805883075e01aeb2cecc89ca4fb266960ae51ada";
const std::string kCode = "CFQV8-1HF8E-2GC65-A8058-0P430";

// A P-256 certificate created with openssl, and its fingerprint by `openssl x509 -fingerprint -sha256`.
constexpr const char* kCertificate = R"(-----BEGIN CERTIFICATE-----
MIIBdDCCARmgAwIBAgIUalnNGEaEoFMV8n0nFnUtqHwvWa8wCgYIKoZIzj0EAwIw
DzENMAsGA1UEAwwEdGVzdDAeFw0yNjExMjIxNzIzNTFaFw0zNjExMTkxNzIzNTFa
MA8xDTALBgNVBAMMBHRlc3QwWTATBgcqhkjOPQIBBggqhkjOPQMBBwNCAAT9X7zI
EbwE+LHv0jGg7D/N/GyqALg91fhhwyYFT22jGhPiYHnYcmfTEyRqq6errTgpTp5C
UZPG8fHQOvhXB6CHo1MwUTAdBgNVHQ4EFgQU+wmVAXSgEtdp8nXpJL4AkWYAAtww
HwYDVR0jBBgwFoAU+wmVAXSgEtdp8nXpJL4AkWYAAtwwDwYDVR0TAQH/BAUwAwEB
/zAKBggqhkjOPQQDAgNJADBGAiEA1ey2p2GpK4/vBnRmG6P90HXQJMrO1UWuSLVw
6BntUx0CIQDygEfLYwPYdVDSRXgADhXmzZJXdaTzK+O11BABJtUAhg==
-----END CERTIFICATE-----
)";
constexpr const char* kCertificateFingerprint =
    "7d90c03b0c54d0ebc781b3688b98b39c97a4e2e80556f5e2471f1215dfda1c07";

unsigned mode_of(const std::filesystem::path& path) {
  struct stat about {};
  return ::stat(path.c_str(), &about) == 0 ? about.st_mode & 0777 : 0;
}

TEST(Fingerprint, MatchesOpenssl) {
  const auto fingerprint = certificate_fingerprint(kCertificate);
  ASSERT_TRUE(fingerprint) << fingerprint.error().message;
  EXPECT_EQ(*fingerprint, kCertificateFingerprint);
  const std::string pem = kCertificate;
  for (size_t size = 0; size + 30 < pem.size(); size += 7)
    EXPECT_FALSE(certificate_fingerprint(pem.substr(0, size)));
  EXPECT_FALSE(certificate_fingerprint("no certificate"));
}

TEST(PairingCode, IsTheFirst125BitsOfTheFingerprint) {
  EXPECT_EQ(pairing_code(kFingerprint), kCode);
  for (const std::string& code :
       {kCode, std::string("cfqv8 1hf8e 2gc65 a8058 0p430"), std::string("CFQV8LHF8E2GC65A8O58OP43O")}) {
    EXPECT_TRUE(check_pairing_code(code)) << code;
    EXPECT_TRUE(fits_pairing_code(kFingerprint, code)) << code;
  }
}

TEST(PairingCode, RejectsAnyOtherDigit) {
  for (size_t i = 0; i < kCode.size(); ++i) {
    if (kCode[i] == '-') continue;
    std::string other = kCode;
    other[i] = other[i] == 'Z' ? 'Y' : 'Z';
    EXPECT_FALSE(fits_pairing_code(kFingerprint, other)) << other;
  }
  // The last of the 125 bits is the first bit of the 32nd digit; the other bits of that digit do not count.
  std::string near = kFingerprint;
  ASSERT_EQ(near[31], '7');
  near[31] = 'f';
  EXPECT_FALSE(fits_pairing_code(near, kCode));
  near[31] = '6';
  EXPECT_TRUE(fits_pairing_code(near, kCode));
}

TEST(PairingCode, RejectsMalformedCodes) {
  for (const char* text : {"", "CFQV8", "CFQV8-1HF8E-2GC65-A8058-0P43", "CFQV8-1HF8E-2GC65-A8058-0P4300",
                           "CFQV8-1HF8E-2GC65-A8058-0P43U",
                           "63efb4062f43850618aa400a805883075e01aeb2cecc89ca4fb266960ae51ada"}) {
    EXPECT_FALSE(check_pairing_code(text)) << text;
    EXPECT_FALSE(fits_pairing_code(kFingerprint, text)) << text;
  }
  EXPECT_FALSE(fits_pairing_code("", ""));
}

TEST(HostPort, DetectsLoopbackAddresses) {
  for (const char* text : {"127.0.0.1:1", "127.3.2.1:65535", "localhost:0", "[::1]:9780"}) {
    const auto parsed = parse_host_port(text);
    ASSERT_TRUE(parsed) << text;
    EXPECT_TRUE(parsed->loopback) << text;
  }
  for (const char* text : {"0.0.0.0:1", "[::]:1", "127.0.0.1.example.org:80", "127.1:80", "::1:80",
                           "10.0.0.1:1", "localhost.:1"}) {
    const auto parsed = parse_host_port(text);
    ASSERT_TRUE(parsed) << text;
    EXPECT_FALSE(parsed->loopback) << text;
  }
  for (const char* text : {"", ":1", "host", "host:", "host:x", "host:1x", "host:65536", "host:-1"})
    EXPECT_FALSE(parse_host_port(text)) << text;
}

TEST(SecretFile, IsReadableByItsOwnerOnly) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "state" / "key";
  ASSERT_TRUE(write_secret_file(file, "secret"));
  EXPECT_EQ(mode_of(file), 0600u);
  EXPECT_EQ(mode_of(file.parent_path()), 0700u);
  EXPECT_EQ(*read_secret_file(file), "secret");
  constexpr uid_t kOther = 10001;  // root owns what it writes; the rule is for files of other users
  if (::getuid() == 0) ASSERT_EQ(::chown(file.c_str(), kOther, kOther), 0);
  for (const mode_t mode : {0640, 0604, 0660}) {
    ::chmod(file.c_str(), mode);
    const auto read = read_secret_file(file);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find(file.string()), std::string::npos) << read.error().message;
  }
  ASSERT_TRUE(write_secret_file(file, "again"));  // with any previous mode
  EXPECT_EQ(mode_of(file), 0600u);
}

// As in a pod: root owns the file of a Secret, and the group of the service may read it.
TEST(SecretFile, OfRootMayBeReadableByItsGroup) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can act as a service to which root gives a file";
  const ScratchFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  constexpr uid_t kService = 65534;
  const std::filesystem::path file = folder.write("key", "secret");
  ASSERT_EQ(::chown(file.c_str(), 0, kService), 0);
  ASSERT_EQ(::setegid(kService), 0);
  ASSERT_EQ(::seteuid(kService), 0);
  const auto allowed = [&](mode_t mode) {
    EXPECT_EQ(::seteuid(0), 0);
    EXPECT_EQ(::chmod(file.c_str(), mode), 0);
    EXPECT_EQ(::seteuid(kService), 0);
    return static_cast<bool>(read_secret_file(file));
  };
  EXPECT_TRUE(allowed(0440));
  EXPECT_TRUE(allowed(0640));
  EXPECT_FALSE(allowed(0660));
  EXPECT_FALSE(allowed(0444));
  EXPECT_EQ(::seteuid(0), 0);
  EXPECT_EQ(::setegid(0), 0);
}

TEST(KnownServers, AreSavedAndDeleted) {
  const ScratchFolder folder;
  const KnownServers servers(folder / "state" / "known_servers");
  EXPECT_FALSE(*servers.find("a:1"));
  ASSERT_TRUE(servers.remember("a:1", {kFingerprint, "livegs_token"}));
  ASSERT_TRUE(servers.remember("b:2", {kFingerprint, ""}));
  ASSERT_TRUE(servers.remember("a:1", {kCertificateFingerprint, "livegs_other"}));
  EXPECT_EQ((*servers.find("a:1"))->fingerprint, kCertificateFingerprint);
  EXPECT_EQ((*servers.find("a:1"))->token, "livegs_other");
  EXPECT_EQ((*servers.find("b:2"))->token, "");
  ASSERT_TRUE(servers.remove_server_entry("a:1"));
  EXPECT_FALSE(*servers.find("a:1"));
  EXPECT_TRUE(*servers.find("b:2"));
  EXPECT_FALSE(servers.remove_server_entry("a:1"));
  EXPECT_EQ(mode_of(folder / "state" / "known_servers"), 0600u);
}

TEST(KnownServers, ReportInvalidLines) {
  const ScratchFolder folder;
  const KnownServers servers(folder / "known_servers");
  for (const std::string& line : {std::string("a:1"), "a:1 " + kFingerprint,
                                  "a:1 " + kFingerprint + " - more", std::string("a:1 63ef -")}) {
    ASSERT_TRUE(write_secret_file(folder / "known_servers", "b:2 " + kFingerprint + " -\n" + line + "\n"));
    const auto found = servers.find("b:2");
    ASSERT_FALSE(found) << line;
    EXPECT_NE(found.error().message.find("known_servers:2"), std::string::npos) << found.error().message;
  }
}

class Access : public ::testing::Test {
 protected:
  Access() { options_.state_dir = folder_ / "state"; }
  const ScratchFolder folder_;
  AccessOptions options_;
};

TEST_F(Access, LoopbackNeedsNoPairing) {
  const auto access = choose_access("127.0.0.1:9780", options_);
  ASSERT_TRUE(access) << access.error().message;
  EXPECT_EQ(*access, nullptr);
  EXPECT_FALSE(std::filesystem::exists(options_.state_dir));
}

TEST_F(Access, RemoteServersNeedPairing) {
  const auto refused = choose_access("192.168.1.2:9780", options_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("--pair"), std::string::npos) << refused.error().message;
  options_.pairing_code = kCode;
  const auto pairing = choose_access("192.168.1.2:9780", options_);
  ASSERT_TRUE(pairing) << pairing.error().message;
  EXPECT_NE(*pairing, nullptr);
  options_.pairing_code = "1234-5678";
  EXPECT_FALSE(choose_access("192.168.1.2:9780", options_));
  options_.pairing_code.clear();
  ASSERT_TRUE(
      KnownServers(options_.state_dir / "known_servers").remember("192.168.1.2:9780", {kFingerprint, ""}));
  EXPECT_TRUE(choose_access("192.168.1.2:9780", options_));
}

// After pairing, a local address is never contacted without TLS: that would permit a downgrade.
TEST_F(Access, PairedServersAlwaysUseTls) {
  ASSERT_TRUE(
      KnownServers(options_.state_dir / "known_servers").remember("127.0.0.1:9780", {kFingerprint, ""}));
  EXPECT_NE(*choose_access("127.0.0.1:9780", options_), nullptr);
  ASSERT_TRUE(unpair_server("127.0.0.1:9780", options_.state_dir));
  EXPECT_EQ(*choose_access("127.0.0.1:9780", options_), nullptr);
}

TEST_F(Access, TokenIsTheFirstLineOfItsFile) {
  options_.pairing_code = kCode;
  options_.token_file = folder_.write("good", "livegs_abc\r\nmore\n");
  EXPECT_TRUE(choose_access("a:1", options_));
  for (const char* text : {"", "\n", "two words\n", "tab\there\n"}) {
    options_.token_file = folder_.write("bad", text);
    EXPECT_FALSE(choose_access("a:1", options_)) << text;
  }
}

// A server with TLS is in tests/system/programs/security_test.cpp.
TEST(ServerProbe, NothingSpeaksTlsWhereNothingListens) {
  EXPECT_FALSE(speaks_tls("127.0.0.1:1"));
  EXPECT_FALSE(speaks_tls("[::1]:1"));
  EXPECT_FALSE(speaks_tls("nowhere"));
}

}  // namespace
}  // namespace livegs
