// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic_device.h"

#include <utility>

namespace livegs {
namespace {

std::shared_ptr<ElasticDevice>& device_of_the_process() {
  static std::shared_ptr<ElasticDevice> device;
  return device;
}

}  // namespace

void set_elastic_device(std::shared_ptr<ElasticDevice> device) {
  device_of_the_process() = std::move(device);
}
ElasticDevice* elastic_device() { return device_of_the_process().get(); }

}  // namespace livegs
