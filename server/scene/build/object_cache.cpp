// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/object_cache.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>

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
  std::string key = bytes_of(described) + '\n' + bytes_of(sidecar) + '\n' + sidecar_path.string() + '\n' +
                    std::to_string(settings.rate_hz) + ' ' + std::to_string(settings.substeps) + ' ' +
                    std::to_string(static_cast<int>(settings.elastic_solver)) + '\n';
  switch (object.form_case()) {
    case v1::Object::kAsset:
      return key + ObjectCache::stamp_of(folder / object.asset());
    case v1::Object::kPoints:
      return key + ObjectCache::stamp_of(folder / object.points()) + std::to_string(index);
    default:
      return key + std::to_string(index);  // selects the colour
  }
}

}  // namespace

std::string ObjectCache::stamp_of(const fs::path& path) {
  std::error_code error;
  std::string stamp;
  const auto add = [&](const fs::path& file) {
    stamp += file.string() + '|' + std::to_string(fs::file_size(file, error)) + '|' +
             std::to_string(fs::last_write_time(file, error).time_since_epoch().count()) + ';';
  };
  const fs::path folder = path.filename() == "meta.json" ? path.parent_path() : path;
  if (!fs::is_directory(folder, error)) {
    add(path);
    return stamp;
  }
  std::vector<fs::path> files;
  for (const auto& file : fs::directory_iterator(folder, error)) files.push_back(file.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) add(file);
  return stamp;
}

const ObjectCache::Entry* ObjectCache::find(const std::string& key) {
  const auto found = entries_.find(key);
  if (found == entries_.end()) return nullptr;
  by_age_.splice(by_age_.begin(), by_age_, found->second.age);
  return &found->second;
}

void ObjectCache::keep(const std::string& key, Entry entry) {
  std::lock_guard lock(mutex_);
  if (find(key)) return;
  by_age_.push_front(key);
  entry.age = by_age_.begin();
  kernels_ += entry.kernels;
  entries_[key] = std::move(entry);
  while (kernels_ > kMaxKernels && by_age_.size() > 1) {
    const auto oldest = entries_.find(by_age_.back());
    kernels_ -= oldest->second.kernels;
    entries_.erase(oldest);
    by_age_.pop_back();
  }
}

Result<BuiltObject> ObjectCache::build(const v1::Object& object, const fs::path& folder, int index,
                                       const std::string& field, const WorldSettings& settings,
                                       const ObjectSidecar& sidecar) {
  ObjectSidecar read = sidecar;
  v1::PhysicsFile kept;
  if (!sidecar.replacement && !sidecar.path.empty()) {
    auto file = read_physics_file(sidecar.path);
    if (!file)
      return build_object(object, folder, index, field, settings, sidecar, &forms_);  // names the error
    kept = std::move(*file);
    read.replacement = &kept;
  }
  const std::string key = key_of(object, folder, index, settings, sidecar.path,
                                 read.replacement ? *read.replacement : v1::PhysicsFile());
  {
    std::lock_guard lock(mutex_);
    if (const Entry* entry = find(key)) {
      BuiltObject again = *entry->object;
      again.build_ms = 0;
      place_built(again, object);
      return again;
    }
  }
  auto built = build_object(object, folder, index, field, settings, read, &forms_);
  if (built)
    keep(key,
         {std::make_shared<const BuiltObject>(*built), nullptr, nullptr, {}, built->drawn.asset->size(), {}});
  return built;
}

std::shared_ptr<const FragileObject> ObjectCache::cut(const std::string& key) {
  std::lock_guard lock(mutex_);
  const Entry* entry = find(key);
  return entry ? entry->pieces : nullptr;
}

void ObjectCache::keep_cut(const std::string& key, const FragileObject& cut,
                           std::vector<std::shared_ptr<const void>> inputs) {
  const size_t kernels = cut.broken->asset->size();
  keep(key, {nullptr, std::make_shared<const FragileObject>(cut), nullptr, std::move(inputs), kernels, {}});
}

std::shared_ptr<const void> ObjectCache::value(const std::string& key) {
  std::lock_guard lock(mutex_);
  const Entry* entry = find(key);
  return entry ? entry->value : nullptr;
}

void ObjectCache::keep_value(const std::string& key, std::shared_ptr<const void> value, size_t kernels) {
  {
    std::lock_guard lock(mutex_);
    if (const auto known = entries_.find(key); known != entries_.end()) {
      kernels_ -= known->second.kernels;
      by_age_.erase(known->second.age);
      entries_.erase(known);
    }
  }
  keep(key, {nullptr, nullptr, std::move(value), {}, kernels, {}});
}

}  // namespace livegs
