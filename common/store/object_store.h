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

// Largest object that is read whole, bytes.
inline constexpr std::uint64_t kMaxObjectBytes = std::uint64_t{4} << 30;

// Limits of one call, seconds.
struct StoreTimes {
  double patience_s = 20;  // without a byte, over all repetitions of a failing request; the time in which an
                           // upload sends bytes does not count
  double stall_s = 10;     // without a byte, of one request
};

// Whether the text is an address (http://, https://, s3://) instead of a path.
bool is_store_url(std::string_view text);
// The address without user, password and query, which may hold a key; for messages and logs. A path is
// unchanged.
std::string shown_url(std::string_view text);

// A place of objects by name: a folder, an HTTP server, or a bucket of an S3-compatible store. Names are
// relative paths with "/". Any thread.
//
// - FOLDER: files. put() replaces a file atomically.
// - http://HOST/PATH, https://HOST/PATH: GET with ranges, HEAD and PUT of PATH/NAME, for public places and
//   presigned addresses: a name may end in a query ("photos.zip?X-Amz-Signature=...").
// - s3://BUCKET/PREFIX: the same, signed with AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and, if it is set,
//   AWS_SESSION_TOKEN, for AWS_REGION (AWS_DEFAULT_REGION, us-east-1). AWS_ENDPOINT_URL names another store
//   than Amazon's. Without keys the requests are not signed.
//
// A request that fails in passing (no connection, cut or stalled transfer, status 408, 429 or 5xx) is
// repeated, a read from its last byte on, until no byte moved for StoreTimes::patience_s. A read gives the
// bytes of one version of an object (ETag, Last-Modified, size). Errors name the object and the cause, never
// a key:
// - Unavailable: passing, but patience ended; the object changes again and again; or `stop` was requested.
// - NotFound: no such object (404, 410).
// - PermissionDenied: 401, 403.
// - InvalidData: wrong range, size or hash.
// - InvalidArgument: any other refusal.
class ObjectStore {
 public:
  // InvalidArgument for an address without a host or bucket, or for a name of the environment that is
  // missing.
  static Result<std::shared_ptr<ObjectStore>> open(const std::string& place, const StoreTimes& times = {});
  virtual ~ObjectStore() = default;

  // Takes a piece of an object, in order; an error ends the transfer. If the object changes during the
  // transfer, its pieces begin again at the offset of the first one, and those before are void.
  using Take = std::function<Result<void>(std::uint64_t offset, std::span<const std::byte> bytes)>;
  // The bytes from `offset` on; none at the end of the object.
  virtual Result<void> read(const std::string& name, std::uint64_t offset, const Take& take,
                            std::stop_token stop = {}) = 0;
  // Creates or replaces an object.
  virtual Result<void> put(const std::string& name, std::span<const std::byte> bytes,
                           std::stop_token stop = {}) = 0;
  // The same from a regular file of any size, which is not copied into memory and must not become shorter.
  Result<void> put_file(const std::string& name, const std::filesystem::path& path,
                        std::stop_token stop = {});
  // Bytes of an object; nothing if it does not exist.
  virtual Result<std::optional<std::uint64_t>> size(const std::string& name, std::stop_token stop = {}) = 0;

  // The whole object. TooLarge above `max_bytes`.
  Result<std::vector<std::byte>> get(const std::string& name, std::uint64_t max_bytes = kMaxObjectBytes,
                                     std::stop_token stop = {});
  // The object whose name is the SHA-256 of its bytes. InvalidData if another attempt also has other bytes.
  Result<std::vector<std::byte>> get_by_hash(const std::string& hash,
                                             std::uint64_t max_bytes = kMaxObjectBytes,
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
