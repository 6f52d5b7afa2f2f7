// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/access/server_security.h"

#include <fcntl.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "core/file.h"
#include "core/log.h"
#include "session/access/browser_link.h"
#include "trust/fingerprint.h"
#include "trust/state_folder.h"

namespace livegs {
namespace {

constexpr const char* kKeyFile = "server.key";
constexpr const char* kCertificateFile = "server.crt";
constexpr const char* kAdminFile = "admin.token";
constexpr const char* kRunningFile = "running";
constexpr long kCertificateDays = 3650;  // clients check the fingerprint, not the dates

bool is_host_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '.';
  });
}

struct Identity {
  std::string certificate_pem, key_pem;
};

template <class Write>
std::string pem_of(Write write) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> text(BIO_new(BIO_s_mem()), &BIO_free);
  if (!text || write(text.get()) != 1) return "";
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(text.get(), &bytes);
  return {bytes, static_cast<size_t>(size)};
}

// The names by which browsers on the LAN reach this machine now (RFC 5280, section 4.2.1.6).
std::string alternative_names() {
  std::string names = "DNS:livegs,DNS:localhost,IP:::1";
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0 && is_host_name(host.data()))
    names += std::string(",DNS:") + host.data();
  for (const std::string& address : machine_addresses()) names += ",IP:" + address;
  return names;
}

Result<Identity> make_identity() {
  const Error failed{ErrorCode::Internal, "certificate: libssl could not create one"};
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_EC_gen("P-256"), &EVP_PKEY_free);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(X509_new(), &X509_free);
  if (!key || !certificate) return failed;
  X509* one = certificate.get();
  uint64_t serial = 0;
  X509_NAME* name = X509_get_subject_name(one);
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, one, one, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, decltype(&X509_EXTENSION_free)> names(
      X509V3_EXT_conf_nid(nullptr, &context, NID_subject_alt_name, alternative_names().c_str()),
      &X509_EXTENSION_free);
  const bool made =
      names && RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) == 1 &&
      X509_set_version(one, X509_VERSION_3) == 1 &&
      ASN1_INTEGER_set_uint64(X509_get_serialNumber(one), serial >> 1) == 1 &&
      X509_gmtime_adj(X509_getm_notBefore(one), -86400) != nullptr &&
      X509_gmtime_adj(X509_getm_notAfter(one), kCertificateDays * 86400) != nullptr &&
      X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("livegs"),
                                 -1, -1, 0) == 1 &&
      X509_set_issuer_name(one, name) == 1 && X509_set_pubkey(one, key.get()) == 1 &&
      X509_add_ext(one, names.get(), -1) == 1 && X509_sign(one, key.get(), EVP_sha256()) > 0;
  if (!made) return failed;
  Identity identity;
  identity.certificate_pem = pem_of([&](BIO* text) { return PEM_write_bio_X509(text, one); });
  identity.key_pem = pem_of([&](BIO* text) {
    return PEM_write_bio_PrivateKey(text, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  });
  if (identity.certificate_pem.empty() || identity.key_pem.empty()) return failed;
  return identity;
}

// True if the key matches the certificate. Otherwise every handshake would fail.
bool belong_together(const Identity& identity) {
  const auto bio = [](const std::string& text) {
    return std::unique_ptr<BIO, decltype(&BIO_free)>(
        BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), &BIO_free);
  };
  const auto certificate_text = bio(identity.certificate_pem), key_text = bio(identity.key_pem);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      PEM_read_bio_X509(certificate_text.get(), nullptr, nullptr, nullptr), &X509_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      PEM_read_bio_PrivateKey(key_text.get(), nullptr, nullptr, nullptr), &EVP_PKEY_free);
  return certificate && key && X509_check_private_key(certificate.get(), key.get()) == 1;
}

Result<Identity> read_identity(const CertificateFiles& files) {
  auto certificate = read_text_file(files.certificate, 1 << 20);
  if (!certificate) return certificate.error();
  auto key = read_secret_file(files.key);
  if (!key) return key.error();
  Identity identity{std::move(*certificate), std::move(*key)};
  if (!belong_together(identity))
    return invalid_data(files.key.string() + ": is not the key of " + files.certificate.string() +
                        "; give the two files of one certificate, in PEM");
  return identity;
}

// Reads the identity from the folder, or creates one. A key without a certificate was never used and is
// replaced.
Result<Identity> identity_in(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::exists(folder / kCertificateFile, error)) {
    auto made = make_identity();
    if (!made) return made;
    if (auto written = write_secret_file(folder / kKeyFile, made->key_pem); !written) return written.error();
    if (auto written = write_secret_file(folder / kCertificateFile, made->certificate_pem); !written)
      return written.error();
    log_info("%s: certificate created", folder.c_str());
    return made;
  }
  auto certificate = read_text_file(folder / kCertificateFile, 1 << 20);
  if (!certificate) return certificate.error();
  auto key = read_secret_file(folder / kKeyFile);
  if (!key) return key.error();
  Identity identity{std::move(*certificate), std::move(*key)};
  if (!belong_together(identity)) {
    return invalid_data(
        folder.string() +
        ": server.key and server.crt do not match; remove both files and pair the clients again");
  }
  return identity;
}

}  // namespace

Result<std::unique_ptr<ServerSecurity>> ServerSecurity::open(const std::filesystem::path& folder,
                                                             WallClock clock,
                                                             const std::optional<CertificateFiles>& own) {
  if (auto made = make_state_folder(folder); !made) return made.error();
  std::unique_ptr<ServerSecurity> security(new ServerSecurity);
  security->folder_ = folder;
  const std::filesystem::path running = folder / kRunningFile;
  security->lock_ = ::open(running.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (security->lock_ < 0) {
    return Error{ErrorCode::PermissionDenied, running.string() +
                                                  ": cannot be written: " + std::strerror(errno) +
                                                  "; choose another folder with --state-dir DIR"};
  }
  if (::flock(security->lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(std::exchange(security->lock_, -1));
    return Error{
        ErrorCode::Unavailable,
        folder.string() +
            ": is in use by another server; stop that server, or choose another folder with --state-dir DIR"};
  }
  auto identity = own ? read_identity(*own) : identity_in(folder);
  if (!identity) return identity.error();
  auto fingerprint = certificate_fingerprint(identity->certificate_pem);
  if (!fingerprint) return fingerprint.error();
  auto tokens = TokenStore::open(folder / "tokens.json", std::move(clock));
  if (!tokens) return tokens.error();
  security->certificate_pem_ = std::move(identity->certificate_pem);
  security->key_pem_ = std::move(identity->key_pem);
  security->fingerprint_ = std::move(*fingerprint);
  security->tokens_ = std::move(*tokens);
  if (auto written = write_secret_file(folder / kAdminFile, security->tokens_->add_local_admin() + "\n");
      !written)
    return written.error();
  return security;
}

ServerSecurity::~ServerSecurity() {
  if (lock_ < 0) return;
  if (tokens_) {
    ::unlink((folder_ / kAdminFile).c_str());
    (void)::ftruncate(lock_, 0);
  }
  ::close(lock_);
}

void ServerSecurity::set_port(int port) {
  const std::string text = std::to_string(port) + "\n" + fingerprint_ + "\n";
  if (::ftruncate(lock_, 0) != 0 || ::pwrite(lock_, text.data(), text.size(), 0) < 0)
    log_warn("%s: the port could not be saved: %s; livegs ctl cannot find this server", folder_.c_str(),
             std::strerror(errno));
}

Result<LocalServer> find_local_server(const std::filesystem::path& folder) {
  const Error none =
      not_found("no server with TLS is running on this machine; its folder would be " + folder.string());
  const int running = ::open((folder / kRunningFile).c_str(), O_RDONLY | O_CLOEXEC);
  if (running < 0) return none;
  const bool held = ::flock(running, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  char text[128] = {};
  const ssize_t size = ::pread(running, text, sizeof text - 1, 0);
  ::close(running);
  LocalServer server;
  const char* end = text + std::max<ssize_t>(size, 0);
  const auto port = std::from_chars(text, end, server.port);
  if (!held || port.ec != std::errc() || port.ptr == end) return none;
  server.fingerprint.assign(port.ptr + 1, std::find(port.ptr + 1, end, '\n'));
  auto token = read_secret_file(folder / kAdminFile);
  if (!token) return token.error();
  server.token = token->substr(0, token->find('\n'));
  return server;
}

}  // namespace livegs
