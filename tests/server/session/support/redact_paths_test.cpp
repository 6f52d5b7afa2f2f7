// SPDX-License-Identifier: Apache-2.0
#include "session/support/redact_paths.h"

#include <gtest/gtest.h>

#include "core/result.h"
#include "session/rpc/grpc_status.h"

namespace livegs {
namespace {

TEST(WithoutFolders, AbsolutePathsBecomeNames) {
  const std::pair<const char*, const char*> messages[] = {
      {"/srv/scenes/mug.physics.json: physics.friction: is 9; mend it",
       "mug.physics.json: physics.friction: is 9; mend it"},
      {"/srv/my scenes/a mug.physics.json: is 9", "a mug.physics.json: is 9"},
      {"objects[0].asset: /srv/x/cup.ply: no such file", "objects[0].asset: cup.ply: no such file"},
      {"\"/srv/x/cup.ply\" and '/a/b' cannot be read", "\"cup.ply\" and 'b' cannot be read"},
      {"between /srv/a b/c and /srv/d", "between c and d"},
      {"cannot write /srv/a (2)/x.json", "cannot write x.json"},
      {"is in /srv/scenes/", "is in scenes/"},
      {"/x", "x"},
      {"/", "/"},
      {"a / b", "a / b"},
      {"cup.ply: is 3 kg/m3 and/or a/b/c, 1 / 2", "cup.ply: is 3 kg/m3 and/or a/b/c, 1 / 2"},
      {"http://127.0.0.1:1234/v1: refused", "http://127.0.0.1:1234/v1: refused"},
      {"", ""}};
  for (const auto& [message, expected] : messages) EXPECT_EQ(redact_paths(message), expected);
}

TEST(WithoutFolders, ClientStatusHasNoFolders) {
  const grpc::Status status =
      to_status({ErrorCode::InvalidData, "/srv/scenes/mug.physics.json: is not JSON"});
  EXPECT_EQ(status.error_message(), "mug.physics.json: is not JSON");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace livegs
