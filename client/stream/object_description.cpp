// SPDX-License-Identifier: Apache-2.0
#include "stream/object_description.h"

#include "core/file.h"
#include "wire/rest_body_codec.h"

namespace livegs {

Result<StreamedObject> read_description(const v1::ObjectDescription& description) {
  StreamedObject object;
  object.id = description.object_id();
  object.name = description.name();
  object.asset_hash = description.asset_hash();
  object.asset_bytes = description.asset_bytes();
  object.environment = description.environment();
  object.kernel_count = description.kernel_count();
  object.mass_kg = description.mass_kg();
  object.physics = description.physics();
  if (description.has_elastic()) object.elastic = description.elastic();
  object.warnings.assign(description.warnings().begin(), description.warnings().end());
  const auto fail = [&](const std::string& what) {
    return invalid_data("object \"" + object.name + "\": " + what);
  };
  if (object.asset_hash.size() != 64 ||
      object.asset_hash.find_first_not_of("0123456789abcdef") != std::string::npos) {
    return fail("its asset_hash is no SHA-256");
  }
  if (object.asset_bytes > kMaxFileBytes) return fail("its asset is over 4 GiB");
  auto rest = decode_rest_body(std::as_bytes(std::span(description.rest_body())));
  if (!rest) return fail(rest.error().message);
  object.rest = std::move(*rest);
  return object;
}

}  // namespace livegs
