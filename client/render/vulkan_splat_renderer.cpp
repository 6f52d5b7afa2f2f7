// SPDX-License-Identifier: Apache-2.0
#include <map>

#include "compute/vulkan_backend.h"
#include "compute/vulkan_handles.h"
#include "core/assert.h"
#include "core/clock.h"
#include "render/splat_painter.h"
#include "render/splat_renderer.h"
#include "splat/frame_splats.h"

namespace livegs {
namespace {

class VulkanSplatRenderer final : public SplatRenderer {
 public:
  VulkanSplatRenderer(std::shared_ptr<VulkanDevice> device, std::unique_ptr<Backend> backend,
                      std::unique_ptr<SplatPainter> painter, const VulkanRendererOptions& options)
      : device_(std::move(device)),
        backend_(std::move(backend)),
        painter_(std::move(painter)),
        frame_(*backend_),
        options_(options),
        name_("vulkan: " + device_->name()) {}

  const std::string& name() const override { return name_; }
  const RenderTimes& last_times() const override { return times_; }
  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, std::vector<Image>& images) override;
  Result<void> draw_into(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                         const RenderOptions& options, const DeviceImage& image) override;

 private:
  using TakeOut = std::function<Result<void>()>;  // of what was painted and resolved
  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes, const RenderOptions& options,
                    const TakeOut& take_out);
  struct Held {
    DeviceKernels kernels;
    uint64_t asset_version = 0, posed_version = 0;
  };
  Result<void> hold(std::span<const RenderedObject> objects);
  // Milliseconds since the last call, after all that was asked for is done.
  Result<double> step_ms();

  std::shared_ptr<VulkanDevice> device_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<SplatPainter> painter_;
  std::map<uint32_t, Held> held_;  // by object id
  FrameSplats frame_;
  VulkanRendererOptions options_;
  std::string name_;
  RenderTimes times_;
  int64_t step_began_ns_ = 0;
};

Result<void> VulkanSplatRenderer::hold(std::span<const RenderedObject> objects) {
  std::map<uint32_t, Held> drawn;
  for (const RenderedObject& object : objects) {
    const uint32_t id = object.drawn.object_id;
    if (const auto found = held_.find(id);
        found != held_.end() && found->second.asset_version == object.asset_version) {
      drawn.insert(held_.extract(found));
    }
  }
  held_ = std::move(drawn);  // what is left out gives its memory back before anything new asks for some
  for (const RenderedObject& object : objects) {
    const uint32_t id = object.drawn.object_id;
    auto held = held_.find(id);
    if (held == held_.end()) {
      auto made = DeviceKernels::create(*backend_, *object.drawn.asset);
      if (!made)
        return Error{made.error().code, "object " + std::to_string(id) + ": " + made.error().message};
      held = held_.emplace(id, Held{*std::move(made), object.asset_version, 0}).first;
    }
    if (held->second.posed_version == object.posed_version) continue;
    if (auto posed = held->second.kernels.pose(*object.drawn.kernels); !posed) return posed;
    held->second.posed_version = object.posed_version;
  }
  return {};
}

Result<double> VulkanSplatRenderer::step_ms() {
  if (options_.separate_times) {
    if (auto done = backend_->submit(); !done) return done.error();
  }
  const int64_t now = now_ns();
  const double passed = milliseconds_from_ns(now - step_began_ns_);
  step_began_ns_ = now;
  return passed;
}

Result<void> VulkanSplatRenderer::draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                                       const RenderOptions& options, std::vector<Image>& images) {
  return draw(objects, eyes, options,
              [&] { return options_.read_blended ? painter_->read_blended(images) : painter_->read(images); });
}

Result<void> VulkanSplatRenderer::draw_into(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                                            const RenderOptions& options, const DeviceImage& image) {
  return draw(objects, eyes, options, [&] { return painter_->copy_into(image); });
}

Result<void> VulkanSplatRenderer::draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                                       const RenderOptions& options, const TakeOut& take_out) {
  LIVEGS_ASSERT(eyes.size() == 1 || eyes.size() == 2);
  LIVEGS_ASSERT(eyes.front().width == eyes.back().width && eyes.front().height == eyes.back().height);
  step_began_ns_ = now_ns();
  const auto timed = [&](Result<void> done, double& ms) -> Result<void> {
    if (!done) return done;
    auto passed = step_ms();
    if (!passed) return passed.error();
    ms = *passed;
    return {};
  };
  if (auto done = timed(hold(objects), times_.upload_ms); !done) return done;
  std::vector<const DeviceKernels*> kernels;
  for (const RenderedObject& object : objects)
    kernels.push_back(&held_.find(object.drawn.object_id)->second.kernels);
  const FrameSplats::Options splats{options.order, options.max_sh_degree, options.max_radius_px, options.min_contribution_px};
  if (auto done = timed(frame_.project(kernels, eyes, splats), times_.project_ms); !done) return done;
  if (auto done = timed(frame_.sort(), times_.sort_ms); !done) return done;
  const auto paint = [&]() -> Result<void> {
    if (auto done = painter_->paint(frame_, eyes[0].width, eyes[0].height, static_cast<int>(eyes.size()));
        !done)
      return done;
    if (auto done = painter_->resolve(options.background); !done) return done;
    return take_out();
  };
  return timed(paint(), times_.draw_ms);
}

}  // namespace

Result<std::unique_ptr<SplatRenderer>> create_vulkan_renderer(std::shared_ptr<VulkanDevice> device,
                                                              const VulkanRendererOptions& options) {
  auto backend = create_vulkan_backend(device);
  if (!backend) return backend.error();
  auto painter = SplatPainter::create(**backend, device->handles(), {.precision = options.precision});
  if (!painter) return painter.error();
  return Result<std::unique_ptr<SplatRenderer>>(std::make_unique<VulkanSplatRenderer>(
      std::move(device), *std::move(backend), *std::move(painter), options));
}

}  // namespace livegs
