// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/build_object.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include "analysis/physics_file.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// Equal messages give equal bytes.
std::string bytes_of(const google::protobuf::Message& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

std::string key_of(const v1::Object& object, const fs::path& folder, int index, const WorldSettings& settings,
                   const fs::path& sidecar_path, const v1::PhysicsFile& sidecar) {
  v1::Object described = object;
  described.clear_pose();
  described.clear_velocity_m_s();
  described.clear_angular_velocity_rad_s();
  described.clear_hidden();
  described.clear_locked();
  described.clear_group();
  described.clear_part();
  std::string key = "object " + bytes_of(described) + '\n' + bytes_of(sidecar) + '\n' +
                    sidecar_path.string() + '\n' + std::to_string(settings.rate_hz) + ' ' +
                    std::to_string(settings.substeps) + '\n';
  switch (object.form_case()) {
    case v1::Object::kAsset:
      return key + BuildCache::stamp_of(folder / object.asset());
    case v1::Object::kPoints:
      return key + BuildCache::stamp_of(folder / object.points()) + std::to_string(index);
    default:
      return key + std::to_string(index);  // selects the colour
  }
}

}  // namespace

Result<BuiltObject> build_cached_object(BuildCache& cache, const v1::Object& object, const fs::path& folder,
                                        int index, const std::string& field, const WorldSettings& settings,
                                        const ObjectSidecar& sidecar) {
  ObjectSidecar read = sidecar;
  v1::PhysicsFile kept;
  if (!sidecar.replacement && !sidecar.path.empty()) {
    auto file = read_physics_file(sidecar.path);
    if (!file)
      return build_object(object, folder, index, field, settings, sidecar, &cache);  // names the error
    kept = std::move(*file);
    read.replacement = &kept;
  }
  const std::string key = key_of(object, folder, index, settings, sidecar.path,
                                 read.replacement ? *read.replacement : v1::PhysicsFile());
  if (const auto known = cache.find<BuiltObject>(key)) {
    BuiltObject again = *known;
    again.build_ms = 0;
    place_built(again, object);
    return again;
  }
  auto built = build_object(object, folder, index, field, settings, read, &cache);
  if (built)
    cache.keep(key, std::make_shared<const BuiltObject>(*built),
               BuildCache::kKernelBytes * built->drawn.asset->size());
  return built;
}

}  // namespace livegs
