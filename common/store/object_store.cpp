// SPDX-License-Identifier: Apache-2.0
#include "store/object_store.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/clock.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "store/http_client.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFilePieceBytes = 1 << 20;
// Pause before a failed request is repeated; doubled each time.
constexpr double kFirstPause_s = 0.1, kMaxPause_s = 2;
constexpr int kMaxChanges = 3;  // of an object during one read

std::string without_trailing_slashes(std::string text) {
  while (text.size() > 1 && text.back() == '/' && !text.ends_with("://")) text.pop_back();
  return text;
}

// The bytes of a file, mapped and read-only.
class MappedFile {
 public:
  explicit MappedFile(const fs::path& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (file >= 0 && ::fstat(file, &status) == 0 && S_ISREG(status.st_mode)) {
      size_ = static_cast<std::size_t>(status.st_size);
      // An empty file cannot be mapped.
      bytes_ = size_ == 0 ? nullptr : ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    }
    if (file >= 0) ::close(file);
  }
  ~MappedFile() {
    if (valid() && size_ > 0) ::munmap(bytes_, size_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  bool valid() const { return bytes_ != MAP_FAILED; }
  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(bytes_), size_}; }

 private:
  void* bytes_ = MAP_FAILED;
  std::size_t size_ = 0;
};

class FolderStore final : public ObjectStore {
 public:
  explicit FolderStore(fs::path folder) : ObjectStore(folder.string()), folder_(std::move(folder)) {}

  Result<void> read(const std::string& name, std::uint64_t offset, const Take& take,
                    std::stop_token stop) override {
    const fs::path path = folder_ / name;
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return not_found(shown(name) + ": does not exist");
    std::ifstream in(path, std::ios::binary);
    if (!in)
      return Error{ErrorCode::PermissionDenied, shown(name) + ": cannot be read; check its permissions"};
    in.seekg(0, std::ios::end);
    const auto total = static_cast<std::uint64_t>(in.tellg());
    if (offset > total) return past_the_end(name, offset, total);
    in.seekg(static_cast<std::streamoff>(offset));
    std::vector<std::byte> piece(kFilePieceBytes);
    while (offset < total) {
      if (stop.stop_requested()) return stopped(name);
      const auto count = std::min<std::uint64_t>(piece.size(), total - offset);
      if (!in.read(reinterpret_cast<char*>(piece.data()), static_cast<std::streamsize>(count)))
        return invalid_data(shown(name) + ": cannot be read whole; check its disk");
      if (auto taken = take(offset, std::span(piece).first(count)); !taken) return taken;
      offset += count;
    }
    return {};
  }

  Result<void> put(const std::string& name, std::span<const std::byte> bytes, std::stop_token) override {
    std::error_code error;
    fs::create_directories((folder_ / name).parent_path(), error);
    return write_file_atomically(folder_ / name, bytes);
  }

  Result<std::optional<std::uint64_t>> size(const std::string& name, std::stop_token) override {
    std::error_code error;
    if (!fs::is_regular_file(folder_ / name, error)) return std::optional<std::uint64_t>();
    const auto bytes = fs::file_size(folder_ / name, error);
    if (error)
      return Error{ErrorCode::PermissionDenied,
                   shown(name) + ": " + error.message() + "; check its permissions"};
    return std::optional<std::uint64_t>(bytes);
  }

 private:
  Error stopped(const std::string& name) const {
    return {ErrorCode::Unavailable, shown(name) + ": the transfer was cancelled"};
  }
  Error past_the_end(const std::string& name, std::uint64_t offset, std::uint64_t total) const {
    return invalid_data(shown(name) + ": has " + std::to_string(total) + " bytes, but byte " +
                        std::to_string(offset) + " was requested");
  }
  const fs::path folder_;
};

// Repeats a request until it succeeds, fails for good, or no byte has moved for the patience.
class Repetition {
 public:
  Repetition(const StoreTimes& times, std::stop_token stop) : times_(times), stop_(std::move(stop)) {}
  void progress() {
    progress_ns_ = now_ns();
    pause_s_ = kFirstPause_s;
  }
  // Time in which bytes moved that must be sent again: it neither counts as patience nor restores it, so that
  // a store which refuses every upload at its end does not receive it for ever.
  void moved(double seconds) { progress_ns_ += static_cast<std::int64_t>(seconds * 1e9); }
  // Whether another attempt is due; waits before it.
  bool again(std::optional<double> retry_after_s) {
    const double pause_s = std::max(pause_s_, std::min(retry_after_s.value_or(0), times_.patience_s));
    const std::int64_t until_ns = now_ns() + static_cast<std::int64_t>(pause_s * 1e9);
    if (until_ns > progress_ns_ + static_cast<std::int64_t>(times_.patience_s * 1e9)) return false;
    constexpr std::int64_t kStopPoll_ns = 20'000'000;
    while (now_ns() < until_ns) {
      if (stop_.stop_requested()) return false;
      sleep_until_ns(std::min(until_ns, now_ns() + kStopPoll_ns));
    }
    pause_s_ = std::min(2 * pause_s_, kMaxPause_s);
    return true;
  }

 private:
  const StoreTimes times_;
  const std::stop_token stop_;
  std::int64_t progress_ns_ = now_ns();
  double pause_s_ = kFirstPause_s;
};

// What a store says of an object besides its bytes; a part may be missing.
struct ObjectVersion {
  std::string tag;  // as HttpReply::version
  std::optional<std::uint64_t> total_bytes;

  bool differs(const ObjectVersion& other) const {
    return (!tag.empty() && !other.tag.empty() && tag != other.tag) ||
           (total_bytes && other.total_bytes && *total_bytes != *other.total_bytes);
  }
};

// The code of an S3 error, such as AccessDenied; empty if the body contains none.
std::string code_of(std::string_view body) {
  constexpr std::string_view kBegin = "<Code>", kEnd = "</Code>";
  constexpr size_t kMaxLength = 64;
  const size_t begin = body.find(kBegin);
  if (begin == body.npos) return {};
  const std::string_view rest = body.substr(begin + kBegin.size(), kMaxLength + kEnd.size());
  const size_t end = rest.find(kEnd);
  if (end == rest.npos) return {};
  const std::string_view code = rest.substr(0, end);
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  return std::all_of(code.begin(), code.end(), plain) ? std::string(code) : "";
}

constexpr std::uint64_t kMaxUploadBytes = std::uint64_t{5} << 30;  // of S3, for one PUT

class HttpStore final : public ObjectStore {
 public:
  HttpStore(std::string base, std::string shown, std::optional<AwsKeys> keys, const StoreTimes& times)
      : ObjectStore(std::move(shown)), base_(std::move(base)), keys_(std::move(keys)), times_(times) {}

  Result<void> read(const std::string& name, std::uint64_t offset, const Take& take,
                    std::stop_token stop) override {
    Repetition repetition(times_, stop);
    std::uint64_t at = offset;
    std::optional<ObjectVersion> version;  // of the bytes before `at`
    int changes = 0;
    for (;;) {
      HttpRequest request = to(name);
      request.from = at;
      // A weak ETag does not stand for the bytes.
      if (version && !version->tag.starts_with("W/")) request.if_version = version->tag;
      std::optional<Error> refused;
      const std::uint64_t begun_at = at;
      bool changed = false;
      request.on_part = [&](const HttpPart& part) {
        const ObjectVersion now{std::string(part.version), part.total_bytes};
        if (version && version->differs(now)) {
          changed = true;
          version.reset();
          at = offset;
          if (part.offset > at) return false;
        }
        if (!version || !now.tag.empty()) version = now;
        if (part.offset > at) {
          refused = invalid_data(shown(name) + ": the store sent bytes from " + std::to_string(part.offset) +
                                 " on instead of " + std::to_string(at));
          return false;
        }
        const std::uint64_t known = at - part.offset;  // of a server without ranges
        if (known >= part.bytes.size()) return true;
        repetition.progress();
        const auto fresh = std::as_bytes(std::span(part.bytes)).subspan(known);
        if (auto taken = take(at, fresh); !taken) {
          refused = taken.error();
          return false;
        }
        at += fresh.size();
        return true;
      };
      const HttpReply reply = client_.send(request, stop);
      if (refused) return *refused;
      if (reply.status == 416 && version && reply.total_bytes != at) {  // it is shorter now
        changed = true;
        version.reset();
        at = offset;
      }
      if (changed && ++changes > kMaxChanges)
        return Error{ErrorCode::Unavailable, shown(name) + ": changes while it is read; try again"};
      if (changed && !version) {
        if (auto taken = take(at, {}); !taken) return taken;  // what was taken is void
        continue;
      }
      if (reply.end == HttpReply::End::Complete) {
        if (reply.status == 416 && reply.total_bytes == at) return {};  // nothing is left
        if (reply.status == 200 || reply.status == 206) {
          if (!reply.total_bytes || *reply.total_bytes == at) return {};
          if (*reply.total_bytes < at)
            return invalid_data(shown(name) + ": has " + std::to_string(*reply.total_bytes) +
                                " bytes, but byte " + std::to_string(at) + " was requested");
          if (at > begun_at || changed) continue;  // the server limits the length of a range
        }
      }
      const Error error = error_of(name, reply);
      if (error.code != ErrorCode::Unavailable || keys_ran_out(reply) ||
          !repetition.again(reply.retry_after_s))
        return error;
      log_debug("%s; resuming at byte %llu", error.message.c_str(), static_cast<unsigned long long>(at));
    }
  }

  Result<void> put(const std::string& name, std::span<const std::byte> bytes, std::stop_token stop) override {
    if (keys_ && bytes.size() > kMaxUploadBytes)
      return Error{ErrorCode::TooLarge, shown(name) +
                                            ": has more than 5 GiB, the limit of S3 for one upload; give "
                                            "a folder or an address that accepts PUT"};
    HttpRequest request = to(name);
    request.put = &bytes;
    const auto reply = repeated(name, request, stop);
    if (!reply) return reply.error();
    if (reply->status >= 200 && reply->status < 300) return {};
    return error_of(name, *reply);
  }

  Result<std::optional<std::uint64_t>> size(const std::string& name, std::stop_token stop) override {
    HttpRequest request = to(name);
    request.head = true;
    auto reply = repeated(name, request, stop);
    const auto refused = [&] {
      const ErrorCode code = error_of(name, *reply).code;
      return reply->status >= 400 && code != ErrorCode::NotFound && code != ErrorCode::Unavailable;
    };
    if (reply && refused()) {
      // A presigned address is valid for one method, some servers have no HEAD, and its reply has no body
      // with the cause. The first piece of a GET has size or cause.
      request.head = false;
      request.on_part = [](const HttpPart&) { return false; };
      reply = repeated(name, request, stop);
    }
    if (!reply) return reply.error();
    if (reply->status == 404 || reply->status == 410) return std::optional<std::uint64_t>();
    if (reply->status != 200) return error_of(name, *reply);
    if (!reply->total_bytes)
      return invalid_data(shown(name) + ": the reply has no size; use a store that sends Content-Range");
    return reply->total_bytes;
  }

 private:
  HttpRequest to(const std::string& name) const {
    HttpRequest request;
    request.url = base_ + "/" + name;
    request.sign = keys_ ? &*keys_ : nullptr;
    request.total_timeout_s = 0;
    request.connect_timeout_s = std::min(request.connect_timeout_s, times_.patience_s);
    request.first_byte_timeout_s = request.stall_timeout_s = times_.stall_s;
    return request;
  }

  // The final reply of a request; an error only if there is none.
  Result<HttpReply> repeated(const std::string& name, const HttpRequest& request, std::stop_token stop) {
    Repetition repetition(times_, stop);
    for (;;) {
      HttpReply reply = client_.send(request, stop);
      repetition.moved(reply.sending_s);
      if (reply.end == HttpReply::End::Complete && reply.status >= 200 && reply.status < 300) return reply;
      const Error error = error_of(name, reply);
      if (error.code == ErrorCode::Unavailable && !keys_ran_out(reply) &&
          repetition.again(reply.retry_after_s))
        continue;
      if (reply.end != HttpReply::End::Complete) return error;
      return reply;
    }
  }

  // A later process may have other keys.
  static bool keys_ran_out(const HttpReply& reply) { return code_of(reply.body) == "ExpiredToken"; }

  Error error_of(const std::string& name, const HttpReply& reply) const {
    const std::string object = shown(name) + ": ";
    switch (reply.end) {
      case HttpReply::End::Complete:
        break;
      case HttpReply::End::BadUrl:
        return invalid_argument(object + "is not a valid address; check its characters");
      case HttpReply::End::BadTls:
        return {ErrorCode::PermissionDenied,
                object + "the certificate of the store is not valid: " + reply.message +
                    "; check the address, or install the certificate of its issuer"};
      default:
        return {ErrorCode::Unavailable, object + reply.message};
    }
    const std::string code = code_of(reply.body);
    const std::string status = "the store answers with status " + std::to_string(reply.status) +
                               (code.empty() ? "" : " (" + code + ")");
    // S3 answers with status 400 to a connection that sends too slowly and to keys that have run out.
    if (code == "RequestTimeout") return {ErrorCode::Unavailable, object + status};
    if (keys_ran_out(reply))
      return {ErrorCode::Unavailable, object + status + "; renew AWS_SESSION_TOKEN and its keys"};
    if (code == "RequestTimeTooSkewed")
      return {ErrorCode::PermissionDenied, object + status + "; set the clock of this machine"};
    if (code == "NoSuchBucket") return invalid_argument(object + status + "; check the name of the bucket");
    switch (reply.status) {
      case 404:
      case 410:
        return not_found(object + "does not exist in the store");
      case 401:
      case 403:
        return {ErrorCode::PermissionDenied,
                object + status +
                    "; check the rights of the object and the keys (S3 refuses absent objects too without "
                    "s3:ListBucket)"};
      case 408:
      case 429:
        return {ErrorCode::Unavailable, object + status};
      default:
        if (reply.status >= 500) return {ErrorCode::Unavailable, object + status};
        if (reply.status >= 300 && reply.status < 400)
          return invalid_argument(object + status + ", a redirect; give the address that it leads to");
        if (reply.status == 200 || reply.status == 206)
          return {ErrorCode::Unavailable, object + "the reply is incomplete"};
        return invalid_argument(object + status + "; check the address and the keys");
    }
  }

  const std::string base_;
  const std::optional<AwsKeys> keys_;
  const StoreTimes times_;
  HttpClient client_;
};

std::string environment(const char* name, const char* otherwise = "") {
  const char* value = std::getenv(name);
  return value && *value ? value : otherwise;
}

// The address of a bucket, and the keys if there are any.
Result<std::shared_ptr<ObjectStore>> open_bucket(const std::string& place, const StoreTimes& times) {
  const std::string rest = place.substr(std::string_view("s3://").size());
  const std::string bucket = rest.substr(0, rest.find('/'));
  const std::string prefix = rest.substr(bucket.size());
  if (bucket.empty()) return invalid_argument(place + ": has no bucket; give s3://BUCKET/PREFIX");
  std::optional<AwsKeys> keys;
  const std::string region =
      environment("AWS_REGION", environment("AWS_DEFAULT_REGION", "us-east-1").c_str());
  if (const std::string access = environment("AWS_ACCESS_KEY_ID"); !access.empty()) {
    std::string secret = environment("AWS_SECRET_ACCESS_KEY"), token = environment("AWS_SESSION_TOKEN");
    if (secret.empty())
      return invalid_argument(
          "AWS_SECRET_ACCESS_KEY: is not set, but AWS_ACCESS_KEY_ID is; set both or none");
    keys = AwsKeys{access, region, Secret(secret), Secret(token)};
    wipe(secret);
    wipe(token);
  }
  const std::string endpoint = without_trailing_slashes(environment("AWS_ENDPOINT_URL"));
  const std::string base = endpoint.empty()
                               ? "https://" + bucket + ".s3." + region + ".amazonaws.com" + prefix
                               : endpoint + "/" + bucket + prefix;
  return std::shared_ptr<ObjectStore>(std::make_shared<HttpStore>(base, place, std::move(keys), times));
}

}  // namespace

bool is_store_url(std::string_view text) {
  return text.starts_with("http://") || text.starts_with("https://") || text.starts_with("s3://");
}

std::string shown_url(std::string_view text) {
  if (!is_store_url(text)) return std::string(text);
  text = text.substr(0, text.find_first_of("?#"));
  const std::size_t host = text.find("://") + 3, path = std::min(text.find('/', host), text.size());
  const std::size_t user = text.substr(host, path - host).rfind('@');
  if (user == std::string_view::npos) return std::string(text);
  return std::string(text.substr(0, host)) + std::string(text.substr(host + user + 1));
}

std::string ObjectStore::shown(const std::string& name) const {
  return shown_place_ + "/" + name.substr(0, name.find('?'));
}

Result<std::shared_ptr<ObjectStore>> ObjectStore::open(const std::string& given, const StoreTimes& times) {
  const std::string place = without_trailing_slashes(given);
  if (!is_store_url(place)) {
    if (place.empty()) return invalid_argument("asset store: is empty; give a folder or an address");
    if (place.find("://") != std::string::npos)
      return invalid_argument(shown_url(place) +
                              ": is not an address of a store; give http://, https:// or s3://");
    return std::shared_ptr<ObjectStore>(std::make_shared<FolderStore>(place));
  }
  if (place.find_first_of("?#") != std::string::npos)
    return invalid_argument(shown_url(place) + ": a store has no query; give the address of a folder");
  if (place.starts_with("s3://")) return open_bucket(place, times);
  const std::size_t host = place.find("://") + 3;
  if (host >= place.size() || place[host] == '/')
    return invalid_argument(place + ": has no host; give http://HOST/PATH");
  return std::shared_ptr<ObjectStore>(
      std::make_shared<HttpStore>(place, shown_url(place), std::nullopt, times));
}

Result<std::vector<std::byte>> ObjectStore::get(const std::string& name, std::uint64_t max_bytes,
                                                std::stop_token stop) {
  std::vector<std::byte> all;
  auto done = read(
      name, 0,
      [&](std::uint64_t offset, std::span<const std::byte> bytes) -> Result<void> {
        all.resize(offset);  // shorter if the object changed
        if (bytes.size() > max_bytes - all.size())
          return Error{ErrorCode::TooLarge,
                       shown(name) + ": is larger than " + std::to_string(max_bytes) + " bytes"};
        all.insert(all.end(), bytes.begin(), bytes.end());
        return {};
      },
      stop);
  if (!done) return done.error();
  return all;
}

Result<void> ObjectStore::put_file(const std::string& name, const fs::path& path, std::stop_token stop) {
  const MappedFile file(path);
  if (!file.valid()) return not_found(path.string() + ": cannot be read; check the path and its permissions");
  return put(name, file.bytes(), stop);
}

Result<std::string> ObjectStore::read_to_file(const std::string& name, const fs::path& path,
                                              std::stop_token stop) {
  const Error unwritten{ErrorCode::Internal,
                        path.string() + ": cannot be written; free space, or set TMPDIR to another folder"};
  ContentHasher hasher;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!out) return unwritten;
  const auto done = read(
      name, 0,
      [&](std::uint64_t offset, std::span<const std::byte> bytes) -> Result<void> {
        if (offset == 0) {  // also if the object changed
          hasher = {};
          out.close();
          out.open(path, std::ios::binary | std::ios::trunc);
        }
        hasher.add(bytes);
        out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!out) return unwritten;
        return {};
      },
      stop);
  if (!done) return done.error();
  out.close();
  if (!out) return unwritten;
  const int written = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = written >= 0 && ::fsync(written) == 0;
  if (written >= 0) ::close(written);
  if (!synced) return unwritten;
  return hasher.hash();
}

Result<std::string> ObjectStore::hash(const std::string& name, std::stop_token stop) {
  ContentHasher hasher;
  auto done = read(
      name, 0,
      [&](std::uint64_t offset, std::span<const std::byte> bytes) -> Result<void> {
        if (offset == 0) hasher = {};
        hasher.add(bytes);
        return {};
      },
      stop);
  if (!done) return done.error();
  return hasher.hash();
}

Result<void> ObjectStore::read_to_file_by_hash(const std::string& hash, const fs::path& path,
                                               std::stop_token stop) {
  constexpr int kAttempts = 2;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto read = read_to_file(hash, path, stop);
    if (!read) return read.error();
    if (*read == hash) return {};
  }
  return invalid_data(shown(hash) + ": its bytes have another hash; publish the scene again with --verify");
}

Result<ObjectPlace> open_object(const std::string& place, const StoreTimes& times) {
  const std::size_t path = is_store_url(place) ? place.find("://") + 3 : 0;
  const std::size_t slash = place.substr(0, place.find_first_of("?#", path)).rfind('/');
  const bool has_folder = slash != std::string::npos && slash >= path;
  if (is_store_url(place) && !has_folder)
    return invalid_argument(shown_url(place) + ": has no name of an object; give the whole address");
  const std::string folder = !has_folder ? "." : slash == 0 ? "/" : place.substr(0, slash);
  const std::string name = has_folder ? place.substr(slash + 1) : place;
  if (name.empty() || name.front() == '?')
    return invalid_argument(shown_url(place) + ": has no name of an object; give the whole address");
  auto store = ObjectStore::open(folder, times);
  if (!store) return store.error();
  return ObjectPlace{*std::move(store), name};
}

}  // namespace livegs
