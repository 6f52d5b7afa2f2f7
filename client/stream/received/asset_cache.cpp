// SPDX-License-Identifier: Apache-2.0
#include "stream/received/asset_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "core/clock.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "core/user_cache.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

Error system_error(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::Internal, path.string() + ": " + what + ": " + std::strerror(errno) +
                                   "; choose another folder with --cache DIR"};
}

// HASH.part, locked against other clients while this object lives. A second client waits for the lock and
// then reads the asset from the cache. The system releases the lock if a client process ends.
class PartFile {
 public:
  static Result<PartFile> open(const std::filesystem::path& path, const std::stop_token& stop) {
    constexpr int64_t kFilePollInterval_ns = 20'000'000;
    for (;;) {
      PartFile file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
      if (file.descriptor_ < 0) return system_error(path, "cannot be written");
      while (::flock(file.descriptor_, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EINTR && errno != EWOULDBLOCK) return system_error(path, "cannot be locked");
        if (stop.stop_requested())
          return Error{ErrorCode::Unavailable,
                       path.string() + ": another client is fetching it; the wait was cancelled"};
        sleep_until_ns(now_ns() + kFilePollInterval_ns);
      }
      struct stat held {
      }, named{};
      ::fstat(file.descriptor_, &held);
      // The other client has renamed the file: start again with a new one.
      if (::stat(path.c_str(), &named) != 0 || named.st_ino != held.st_ino) continue;
      file.size_ = static_cast<uint64_t>(held.st_size);
      return file;
    }
  }
  PartFile(PartFile&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}
  ~PartFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  uint64_t size() const { return size_; }
  bool truncate() {
    size_ = 0;
    return ::ftruncate(descriptor_, 0) == 0;
  }
  bool append(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      size_ += static_cast<uint64_t>(written);
      bytes = bytes.subspan(static_cast<size_t>(written));
    }
    return true;
  }

 private:
  explicit PartFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
  uint64_t size_ = 0;
};

}  // namespace

Result<AssetCache::Obtained> AssetCache::obtain(const std::string& hash, uint64_t asset_bytes,
                                                std::span<const Fetch> sources, const Progress& progress,
                                                std::stop_token stop, const Edit& edit) const {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) {
    return Error{ErrorCode::Internal, folder_.string() + ": cannot be created: " + error.message() +
                                          "; choose another folder with --cache DIR"};
  }
  const std::filesystem::path whole = folder_ / (hash + ".ply");
  const std::filesystem::path part_path = folder_ / (hash + ".part");
  const std::string name = "asset " + hash.substr(0, 12);
  const auto cached = [&]() -> std::vector<std::byte> {
    if (!std::filesystem::exists(whole, error)) return {};
    auto bytes = read_file(whole);
    if (bytes && content_hash(*bytes) == hash) return std::move(*bytes);
    log_warn("%s: the file is damaged; fetching it again", whole.c_str());
    return {};
  };
  if (auto bytes = cached(); !bytes.empty()) return Obtained{std::move(bytes), 0};

  auto part = PartFile::open(part_path, stop);
  if (!part) return part.error();
  if (auto bytes = cached(); !bytes.empty()) {  // another client has fetched it meanwhile
    std::filesystem::remove(part_path, error);
    return Obtained{std::move(bytes), 0};
  }
  if (part->size() > asset_bytes && !part->truncate()) return system_error(part_path, "cannot be truncated");

  uint64_t fetched = 0;
  // Stores a decoded asset in the folder. Null if it has another hash.
  const auto keep = [&](const GaussianAsset& asset) -> Result<std::optional<Obtained>> {
    std::vector<std::byte> bytes = encode_ply(asset);
    if (content_hash(bytes) != hash) return std::optional<Obtained>();
    if (auto written = write_file_atomically(whole, bytes); !written)
      return Error{written.error().code,
                   written.error().message + ", or choose another folder with --cache DIR"};
    std::filesystem::remove(part_path, error);
    return std::optional(Obtained{std::move(bytes), fetched});
  };
  if (auto base = edit.fetch ? edit.base() : nullptr) {
    ProgressiveDecoder edited(std::move(base));
    const auto done =
        edit.fetch(0, [&](uint64_t, uint64_t, std::span<const std::byte> bytes) -> Result<void> {
          fetched += bytes.size();
          if (fetched > asset_bytes) return invalid_data("the edit exceeds the size of the asset");
          return edited.take(bytes);
        });
    if (const auto asset = done ? edited.whole() : std::nullopt) {
      auto kept = keep(*asset);
      if (!kept) return kept.error();
      if (*kept) return **std::move(kept);
    }
    if (stop.stop_requested()) return Error{ErrorCode::Unavailable, name + ": the fetch was cancelled"};
    log_debug("%s: no edit of the earlier asset (%s); fetching the whole asset", name.c_str(),
              done ? "wrong bytes" : done.error().message.c_str());
  }

  ProgressiveDecoder decoder;
  std::optional<Error> spoilt;  // the error in the received bytes
  const auto decode = [&](std::span<const std::byte> bytes) -> Result<void> {
    const size_t before = decoder.blocks();
    if (auto decoded = decoder.take(bytes); !decoded) {
      spoilt = decoded.error();
      return decoded;
    }
    if (progress && decoder.blocks() > before) progress(decoder);
    return {};
  };
  const auto take = [&](uint64_t offset, uint64_t, std::span<const std::byte> bytes) -> Result<void> {
    if (offset != part->size() || bytes.size() > asset_bytes - part->size())
      return invalid_data(name + ": pieces arrive out of order or exceed the size");
    if (!part->append(bytes)) return system_error(part_path, "cannot be written");
    fetched += bytes.size();
    return decode(bytes);
  };
  // Fetches the rest and checks the whole; `spoilt` is set if the bytes were wrong, and they are discarded.
  const auto attempt = [&](const Fetch& fetch) -> Result<Obtained> {
    decoder = {};
    spoilt.reset();
    if (part->size() > 0) {
      const auto earlier = read_file(part_path, asset_bytes);
      if (!earlier) return earlier.error();
      (void)decode(*earlier);
    }
    if (!spoilt && part->size() < asset_bytes) {
      if (auto done = fetch(part->size(), take); !done && !spoilt) return done.error();
    }
    if (!spoilt) {
      const auto asset = decoder.whole();
      if (asset) {
        auto kept = keep(*asset);
        if (!kept) return kept.error();
        if (*kept) return **std::move(kept);
      }
      spoilt = invalid_data("asset: " + std::string(asset ? "the received bytes have a different hash"
                                                          : "the data is incomplete"));
    }
    if (!part->truncate()) return system_error(part_path, "cannot be truncated");
    return invalid_data(name + spoilt->message.substr(spoilt->message.find(':')));
  };
  for (;; sources = sources.subspan(1)) {
    // Data from an earlier attempt may be invalid; in that case the fetch is repeated from the start.
    const bool resumed = part->size() > 0;
    auto obtained = attempt(sources.front());
    if (!obtained && spoilt && resumed) obtained = attempt(sources.front());
    if (obtained || sources.size() == 1 || stop.stop_requested()) return obtained;
    log_warn("%s: fetching it from the server (%s)", name.c_str(), obtained.error().message.c_str());
  }
}

Result<std::filesystem::path> AssetCache::default_folder() {
  auto folder = user_cache_folder();
  if (!folder)
    return Error{folder.error().code, folder.error().message + ", or choose a folder with --cache DIR"};
  return folder;
}

}  // namespace livegs
