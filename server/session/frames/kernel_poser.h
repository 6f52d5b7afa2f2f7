// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "scene/scene.h"
#include "skin/skin_kernels.h"
#include "wire/kernel_codec.h"

namespace livegs {

// Where the kernels of a scene's objects are in frames of its drivers, for streams of kernels. Ties them to
// their drivers when they are first asked for. One thread.
class KernelPoser {
 public:
  // An object that came, or changed; the revision before is kept for frames that are still of it.
  void take(const SceneObject& object);
  void remove(uint32_t object_id) { objects_.erase(object_id); }

  // Objects that were not told of, or do not fit what was told, are left out; so are those, the last, that a
  // frame of this encoding has no room for, with a line in the log.
  KernelFrame pose(const DriverFrame& frame, KernelEncoding encoding);

 private:
  struct Object {
    std::string name;
    std::shared_ptr<const GaussianAsset> asset;
    RestBody rest;
    std::optional<KernelBindings> bindings;
    bool failed = false;  // they cannot be tied
  };
  static bool bind_object(Object& object);

  std::map<uint32_t, std::map<uint32_t, Object>> objects_;  // by id, then revision
  bool warned_of_room_ = false;
};

}  // namespace livegs
