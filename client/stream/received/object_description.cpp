// SPDX-License-Identifier: Apache-2.0
#include "stream/received/object_description.h"

#include <algorithm>
#include <cmath>

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
  object.hidden = description.hidden();
  object.label = description.label();
  object.lift_m = description.lift_m();
  object.kernel_count = description.kernel_count();
  object.mass_kg = description.mass_kg();
  object.physics = description.physics();
  if (description.has_elastic()) object.elastic = description.elastic();
  object.broken_asset_hash = description.broken_asset_hash();
  object.broken_asset_bytes = description.broken_asset_bytes();
  if (description.has_fragility()) object.fragility = description.fragility();
  object.warnings.assign(description.warnings().begin(), description.warnings().end());
  if (description.has_proposal()) object.proposal = description.proposal();
  const auto fail = [&](const std::string& what) {
    return invalid_data("object \"" + object.name + "\": " + what);
  };
  const auto is_hash = [](const std::string& text) {
    return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
  };
  if (!is_hash(object.asset_hash)) return fail("asset_hash is not a SHA-256");
  if (!object.broken_asset_hash.empty() && !is_hash(object.broken_asset_hash)) {
    return fail("broken_asset_hash is not a SHA-256");
  }
  if (std::max(object.asset_bytes, object.broken_asset_bytes) > kMaxFileBytes) {
    return fail("the asset is over 4 GiB");
  }
  if (!std::isfinite(object.lift_m)) return fail("lift_m is not a number");
  auto rest = decode_rest_body(std::as_bytes(std::span(description.rest_body())));
  if (!rest) return fail(rest.error().message);
  object.rest = std::move(*rest);
  uint64_t kernels = 0;
  for (const RestBody::KernelRun& run : object.rest.kernel_runs) kernels += run.count;
  if (object.rest.revision > 0 && kernels != object.kernel_count) {
    return fail("the rest body binds " + std::to_string(kernels) + " of " +
                std::to_string(object.kernel_count) + " kernels");
  }
  return object;
}

}  // namespace livegs
