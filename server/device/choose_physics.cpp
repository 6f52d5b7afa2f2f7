// SPDX-License-Identifier: GPL-3.0-or-later
#include "device/choose_physics.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "compute/vulkan_backend.h"
#include "core/log.h"
#include "core/user_cache.h"
#include "device/device_elastic.h"
#include "device/measure_elastic_cost.h"

namespace livegs {
namespace {

// A DeviceElastic and the backend that it uses.
class OwnDevice final : public ElasticDevice {
 public:
  OwnDevice(std::unique_ptr<Backend> backend, std::optional<ElasticCost> cost)
      : backend_(std::move(backend)), elastic_(*backend_, cost) {}
  void step(std::span<DeviceBody> bodies, const FlatTick& tick) override { elastic_.step(bodies, tick); }

 private:
  std::unique_ptr<Backend> backend_;
  DeviceElastic elastic_;
};

}  // namespace

Result<std::shared_ptr<ElasticDevice>> choose_physics(const std::string& choice) {
  const std::shared_ptr<ElasticDevice> none;
  if (choice == "cpu") return none;
  const bool automatic = choice == "auto";
  VulkanDeviceOptions options;
  options.pipeline_cache_folder = user_pipeline_cache_folder();
  auto device = VulkanDevice::create(options);
  if (!device && !automatic) return device.error();
  if (!device || (automatic && (*device)->is_software())) {
    log_debug("physics: cpu: %s", device ? "the only device is software" : device.error().message.c_str());
    return none;
  }
  const std::string name = (*device)->name();
  auto backend = create_vulkan_backend(*std::move(device));
  if (!backend && !automatic) return backend.error();
  std::optional<ElasticCost> cost;
  if (backend && automatic) {
    const auto folder = user_cache_folder();
    auto known = known_elastic_cost(**backend, name, folder ? *folder : std::filesystem::path());
    if (!known) backend = known.error();
    if (known) cost = *known;
  }
  if (!backend) {
    log_warn("physics: %s: %s; elastic bodies are stepped on the CPU", name.c_str(),
             backend.error().message.c_str());
    return none;
  }
  if (cost) {
    log_info(
        "physics: auto: %s takes %.2f ms a tick, %.3f ms a step and %.2f ns a node; the CPU %.1f ns a node",
        name.c_str(), cost->device_tick_ms, cost->device_step_ms, 1e6 * cost->device_node_step_ms,
        1e6 * cost->cpu_node_step_ms);
  } else {
    log_info("physics: elastic bodies are stepped on %s where it can", name.c_str());
  }
  return std::shared_ptr<ElasticDevice>(std::make_shared<OwnDevice>(*std::move(backend), cost));
}

}  // namespace livegs
