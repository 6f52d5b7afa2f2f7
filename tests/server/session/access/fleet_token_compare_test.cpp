// SPDX-License-Identifier: Apache-2.0
// Where a wrong signature of a fleet token first differs must not show in the time of its refusal. Times are
// too unsteady to test, so this counts the bytes that the comparison of OpenSSL, which takes constant time,
// is given: the linker sends calls of CRYPTO_memcmp here (--wrap).
#include <gtest/gtest.h>

#include "session/access/fleet_token.h"

namespace {
size_t compared_bytes = 0;
}

extern "C" {
int __real_CRYPTO_memcmp(const void* a, const void* b, size_t size);
int __wrap_CRYPTO_memcmp(const void* a, const void* b, size_t size) {
  compared_bytes += size;
  return __real_CRYPTO_memcmp(a, b, size);
}
}

namespace livegs {
namespace {

TEST(FleetTokenComparison, ReadsTheWholeSignatureWhereverItDiffers) {
  constexpr size_t kSignatureBytes = 43;  // HMAC-SHA256 in base64url
  const std::string key(kMinFleetKeyBytes, 'k');
  v1::FleetToken token;
  token.set_server("room-a");
  token.set_name("ada");
  token.set_scope(v1::INTERACT);
  token.set_expires_unix_s(60);
  const std::string good = sign_fleet_token(key, token).value();
  ASSERT_EQ(good.size() - good.find('.') - 1, kSignatureBytes);
  ASSERT_TRUE(verify_fleet_token(key, "room-a", good, 0));
  for (size_t i = good.size() - kSignatureBytes; i < good.size(); ++i) {
    std::string altered = good;
    altered[i] = altered[i] == 'A' ? 'B' : 'A';
    compared_bytes = 0;
    EXPECT_FALSE(verify_fleet_token(key, "room-a", altered, 0)) << i;
    EXPECT_EQ(compared_bytes, kSignatureBytes) << i;
  }
}

}  // namespace
}  // namespace livegs
