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

// Computes the kernels of a scene from its driver frames, for kernel streams. Binds the kernels of an object
// at first use. One thread.
class KernelPoser {
 public:
  // Adds a new or changed object. The previous revision is kept for frames that still use it.
  void take(const SceneObject& object);
  void remove(uint32_t object_id) { objects_.erase(object_id); }

  // Omits objects that are unknown or do not match their description. If the frame exceeds its size limit in
  // this encoding, the last objects are omitted with a log line.
  KernelFrame pose(const DriverFrame& frame, KernelEncoding encoding);

 private:
  struct Object {
    std::string name;
    std::shared_ptr<const GaussianAsset> asset;
    RestBody rest;
    std::optional<KernelBindings> bindings;
    bool failed = false;  // the kernels cannot be bound
  };
  static bool bind_object(Object& object);

  std::map<uint32_t, std::map<uint32_t, Object>> objects_;  // by id, then revision
  bool warned_of_room_ = false;
};

}  // namespace livegs
