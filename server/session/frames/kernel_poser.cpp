// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frames/kernel_poser.h"

#include "core/log.h"
#include "wire/frame_codec.h"

namespace livegs {

void KernelPoser::take(const SceneObject& object) {
  std::map<uint32_t, Object>& revisions = objects_[object.id];
  if (revisions.contains(object.rest.revision)) return;
  while (revisions.size() > 1) revisions.erase(revisions.begin());
  revisions[object.rest.revision] = {object.name, object.asset, object.rest, {}, false};
}

bool KernelPoser::bind_object(Object& object) {
  if (object.bindings || object.failed) return !object.failed;
  auto bindings = bind_kernels(*object.asset, object.rest);
  object.failed = !bindings;
  if (bindings)
    object.bindings = *std::move(bindings);
  else
    log_warn("%s: kernels are not streamed: %s; request frames of drivers", object.name.c_str(),
             bindings.error().message.c_str());
  return !object.failed;
}

KernelFrame KernelPoser::pose(const DriverFrame& frame, KernelEncoding encoding) {
  KernelFrame posed{frame.tick, frame.simulated_ns, {}};
  size_t bytes = kKernelFrameHeaderBytes;
  for (const ObjectDrivers& drivers : frame.objects) {
    const auto known = objects_.find(drivers.object_id);
    if (known == objects_.end()) continue;
    const auto of_revision = known->second.find(drivers.revision);
    if (of_revision == known->second.end()) continue;
    Object& object = of_revision->second;
    bytes += kernel_bytes(object.asset->size(), encoding);
    if (bytes > kMaxFrameBytes) {
      if (!std::exchange(warned_of_room_, true))
        log_warn(
            "%s: this and later objects are not streamed as kernels: the frame is full; request frames of "
            "drivers",
            object.name.c_str());
      break;
    }
    if (!bind_object(object) || !check_drivers(object.rest, drivers)) continue;
    ObjectKernels& one = posed.objects.emplace_back();
    one.object_id = drivers.object_id;
    one.revision = drivers.revision;
    skin_kernels(*object.asset, object.rest, *object.bindings, drivers, one.kernels);
  }
  return posed;
}

}  // namespace livegs
