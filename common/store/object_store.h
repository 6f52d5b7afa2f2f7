// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace livegs {

// Default limit of get(), bytes. Larger: one object may occupy more memory.
inline constexpr std::uint64_t kMaxObjectBytes = std::uint64_t{4} << 30;

// Limits of one call, seconds.
struct StoreTimes {
  // Longest time without a received byte, over all attempts of a request. The time in which an upload sends
  // bytes does not count. Larger: longer outages are tolerated, failures are reported later.
  double patience_s = 20;
  // Longest time without a received byte in one attempt. Larger: a stalled transfer is repeated later.
  double stall_s = 10;
};

// Whether the text is an address (http://, https://, s3://) instead of a path.
bool is_store_url(std::string_view text);
// The address for messages and logs. User, password and query are removed, because they may contain a key. A
// path is unchanged.
std::string shown_url(std::string_view text);

// A store that reads and writes objects by name: a folder, an HTTP server, or a bucket of an S3-compatible
// store. Names are relative paths with "/". Any thread.
//
// - FOLDER: files. put() replaces a file atomically.
// - http://HOST/PATH, https://HOST/PATH: GET with ranges, HEAD and PUT of PATH/NAME, for public places and
//   presigned addresses: a name may end in a query ("photos.zip?X-Amz-Signature=...").
// - s3://BUCKET/PREFIX: the same, signed with AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and, if it is set,
//   AWS_SESSION_TOKEN. The region is AWS_REGION, else AWS_DEFAULT_REGION, else us-east-1. AWS_ENDPOINT_URL
//   selects a store other than Amazon's. Requests without keys are not signed.
//
// A request with a temporary failure (no connection, cut or stalled transfer, status 408, 429 or 5xx,
// RequestTimeout of S3) is repeated until no byte has arrived for StoreTimes::patience_s. A read continues
// after its last byte. It returns the bytes of one version of an object (ETag, Last-Modified, size). Errors
// contain the object and the cause, but not a key:
// - Unavailable: a temporary failure lasted for StoreTimes::patience_s, the object changed more than three
//   times during a read, or `stop` was requested.
// - NotFound: the object does not exist (404, 410).
// - PermissionDenied: status 401 or 403, an invalid certificate, or an unreadable file.
// - InvalidData: wrong range, size or hash.
// - InvalidArgument: an invalid address, or any other status below 500.
class ObjectStore {
 public:
  // InvalidArgument for an address without a host or bucket, or if AWS_ACCESS_KEY_ID is set without
  // AWS_SECRET_ACCESS_KEY.
  static Result<std::shared_ptr<ObjectStore>> open(const std::string& place, const StoreTimes& times = {});
  virtual ~ObjectStore() = default;

  // Receives the pieces of an object in order. An error of the callback ends the transfer. If the object
  // changes during the transfer, the pieces restart at the first offset, and earlier pieces are invalid.
  using Take = std::function<Result<void>(std::uint64_t offset, std::span<const std::byte> bytes)>;
  // Passes the bytes from `offset` on to `take`; none if `offset` is the size of the object.
  virtual Result<void> read(const std::string& name, std::uint64_t offset, const Take& take,
                            std::stop_token stop = {}) = 0;
  // Creates or replaces an object.
  virtual Result<void> put(const std::string& name, std::span<const std::byte> bytes,
                           std::stop_token stop = {}) = 0;
  // The same for the content of a regular file of any size. The file is mapped, not copied. It must not
  // shrink during the call.
  Result<void> put_file(const std::string& name, const std::filesystem::path& path,
                        std::stop_token stop = {});
  // Size of an object, bytes; nullopt if it does not exist.
  virtual Result<std::optional<std::uint64_t>> size(const std::string& name, std::stop_token stop = {}) = 0;

  // The whole object. TooLarge above `max_bytes`.
  Result<std::vector<std::byte>> get(const std::string& name, std::uint64_t max_bytes = kMaxObjectBytes,
                                     std::stop_token stop = {});
  // Writes an object to a file, also to the disk, and returns its SHA-256. After an error, the file may be
  // incomplete. Internal if it cannot be written.
  Result<std::string> read_to_file(const std::string& name, const std::filesystem::path& path,
                                   std::stop_token stop = {});
  // The same for an object whose name is the SHA-256 of its bytes. InvalidData if the hash differs in two
  // attempts.
  Result<void> read_to_file_by_hash(const std::string& hash, const std::filesystem::path& path,
                                    std::stop_token stop = {});
  // SHA-256 of an object; its bytes are not kept.
  Result<std::string> hash(const std::string& name, std::stop_token stop = {});
  std::string shown(const std::string& name) const;  // for messages

 protected:
  explicit ObjectStore(std::string shown_place) : shown_place_(std::move(shown_place)) {}

 private:
  const std::string shown_place_;
};

// An object by its address or path: the store of its folder and its name there.
struct ObjectPlace {
  std::shared_ptr<ObjectStore> store;
  std::string name;
};
// `place`: an address or a path of one object. InvalidArgument if it has no name.
Result<ObjectPlace> open_object(const std::string& place, const StoreTimes& times = {});

}  // namespace livegs
