// SPDX-License-Identifier: Apache-2.0
#include <map>

#include "compute/vulkan_backend.h"
#include "compute/vulkan_commands.h"
#include "compute/vulkan_handles.h"
#include "core/assert.h"
#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "render/renderer/most_visible_kernels.h"
#include "render/splat_renderer.h"
#include "render/vulkan/device_timer.h"
#include "render/vulkan/faster_method.h"
#include "render/vulkan/splat_pass.h"
#include "skin/device_skin.h"
#include "splat/raster/frame_splats.h"

namespace livegs {
namespace {

constexpr double kKernelBackoff = 0.7;        // factor on the number of kernels when memory is exhausted
constexpr double kMinKernelShare = 1.0 / 64;  // below this the CPU renders better

class VulkanSplatRenderer final : public SplatRenderer {
 public:
  VulkanSplatRenderer(std::shared_ptr<VulkanDevice> device, std::unique_ptr<Backend> backend,
                      std::unique_ptr<SplatPass> pass, const VulkanRendererOptions& options)
      : device_(std::move(device)),
        backend_(std::move(backend)),
        timer_(*vulkan_commands(*backend_), device_->handles()),
        pass_(std::move(pass)),
        frame_(*backend_, options.max_part_rows),
        options_(options),
        name_("vulkan: " + device_->name()) {}

  const std::string& name() const override { return name_; }
  bool skins(DriverKind kind) const override { return DeviceSkin::skins(kind); }
  const RenderTimes& last_times() const override { return times_; }
  std::string notice() const override;
  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, std::vector<Image>& images) override;
  Result<void> draw_into(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                         const RenderOptions& options, const DeviceImage& image) override;

 private:
  using TakeOut = std::function<Result<void>()>;  // output of the painted and resolved picture
  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, const TakeOut& take_out);
  Result<void> draw_once(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                         const RenderOptions& options, const TakeOut& take_out);
  struct Held {
    DeviceKernels kernels;
    std::optional<DeviceSkin> skin;  // for kinds that a pass skins
    uint64_t asset_version = 0, posed_version = 0;
  };
  Result<void> hold(std::span<const RenderedObject> objects);
  Result<Held> make_held(const RenderedObject& object);
  FrameSplats::Object frame_object(uint32_t object_id, const Held& held);
  // Waits for all submitted work; milliseconds since the last call.
  Result<double> step_ms();

  std::shared_ptr<VulkanDevice> device_;
  std::unique_ptr<Backend> backend_;
  DeviceTimer timer_;
  std::unique_ptr<SplatPass> pass_;  // submits recorded commands before the timer is destroyed
  std::map<uint32_t, Held> held_;    // by object id
  // Share of each object's kernels that is drawn because the device's memory, or the buffers it can bind,
  // hold no more; and the number of kernels when this was found.
  double share_ = 1;
  bool binds_no_more_ = false;  // the limit is the buffers, not the memory
  uint64_t kernels_then_ = 0;
  FrameSplats frame_;
  VulkanRendererOptions options_;
  std::string name_;
  RenderTimes times_;
  int64_t step_began_ns_ = 0;
};

bool is_skinned_here(const RenderedObject& object) {
  return object.skinned_by.rest && DeviceSkin::skins(object.skinned_by.rest->kind);
}

Result<VulkanSplatRenderer::Held> VulkanSplatRenderer::make_held(const RenderedObject& object) {
  const GaussianAsset& asset = *object.drawn.asset;
  std::vector<uint32_t> kept;
  if (share_ < 1 && asset.size() > 0)
    kept =
        most_visible_kernels(asset, 1 + static_cast<size_t>(share_ * static_cast<double>(asset.size() - 1)));
  std::optional<DeviceSkin> skin;
  if (is_skinned_here(object)) {
    auto made = DeviceSkin::create(*backend_, *object.skinned_by.rest, *object.skinned_by.bindings, kept);
    if (!made) return made.error();
    skin.emplace(*std::move(made));
  }
  auto kernels = DeviceKernels::create(*backend_, asset, std::move(kept));
  if (!kernels) return kernels.error();
  return Result<Held>(Held{*std::move(kernels), std::move(skin), object.asset_version, 0});
}

Result<void> VulkanSplatRenderer::hold(std::span<const RenderedObject> objects) {
  std::map<uint32_t, Held> drawn;
  for (const RenderedObject& object : objects) {
    const uint32_t id = object.drawn.object_id;
    if (const auto found = held_.find(id); found != held_.end() &&
                                           found->second.asset_version == object.asset_version &&
                                           found->second.skin.has_value() == is_skinned_here(object)) {
      drawn.insert(held_.extract(found));
    }
  }
  held_ = std::move(drawn);  // frees the data of removed objects before new allocations
  for (const RenderedObject& object : objects) {
    const uint32_t id = object.drawn.object_id;
    auto found = held_.find(id);
    if (found == held_.end()) {
      auto made = make_held(object);
      if (!made)
        return Error{made.error().code, "object " + std::to_string(id) + ": " + made.error().message};
      found = held_.emplace(id, *std::move(made)).first;
    }
    Held& held = found->second;
    if (held.posed_version == object.posed_version) continue;
    const SkinnedBy& by = object.skinned_by;
    auto posed = held.skin ? held.skin->move(*by.rest, *by.bindings, *by.drivers)
                           : held.kernels.pose(*object.drawn.kernels);
    if (!posed) return posed;
    held.posed_version = object.posed_version;
  }
  return {};
}

FrameSplats::Object VulkanSplatRenderer::frame_object(uint32_t object_id, const Held& held) {
  if (!held.skin) return {&held.kernels, {}, object_id};
  return {&held.kernels,
          [this, &held](uint32_t first, uint32_t count, BufferId posed) -> Result<void> {
            if (auto done = timer_.mark(DevicePass::Skin); !done) return done;
            if (auto done = held.skin->pose(first, count, posed); !done) return done;
            return timer_.mark(DevicePass::Project);
          },
          object_id};
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
              [&] { return options_.read_blended ? pass_->read_blended(images) : pass_->read(images); });
}

Result<void> VulkanSplatRenderer::draw_into(std::span<const RenderedObject> objects,
                                            std::span<const Camera> eyes, const RenderOptions& options,
                                            const DeviceImage& image) {
  return draw(objects, eyes, options, [&] { return pass_->copy_into(image); });
}

std::string VulkanSplatRenderer::notice() const {
  if (share_ == 1) return {};
  if (binds_no_more_)
    return format_text("bindable buffers of %s hold %.0f %% of the kernels; the rest is not drawn",
                       device_->name().c_str(), 100 * share_);
  return format_text("memory of %s holds %.0f %% of the kernels; the rest is not drawn",
                     device_->name().c_str(), 100 * share_);
}

// Draws with fewer kernels while memory is exhausted.
Result<void> VulkanSplatRenderer::draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                                       const RenderOptions& options, const TakeOut& take_out) {
  uint64_t kernels = 0;
  for (const RenderedObject& object : objects) kernels += object.drawn.asset->size();
  if (share_ < 1 &&
      static_cast<double>(kernels) <= share_ * static_cast<double>(kernels_then_)) {  // this number fits
    share_ = 1;
    binds_no_more_ = false;
    held_.clear();
    log_info("%s: all kernels are drawn again", name_.c_str());
  }
  std::optional<Error> ended;
  if (share_ * static_cast<double>(kernels) > static_cast<double>(frame_.max_kernels()) &&
      frame_.max_kernels() > objects.size()) {
    // Rounding may add one kernel per object.
    share_ = static_cast<double>(frame_.max_kernels() - objects.size()) / static_cast<double>(kernels);
    binds_no_more_ = true;
    kernels_then_ = kernels;
    held_.clear();
    frame_.release_buffers();
    log_warn("%s", notice().c_str());
  }
  auto done = draw_once(objects, eyes, options, take_out);
  while (!done && done.error().code == ErrorCode::TooLarge && share_ >= kMinKernelShare) {
    ended = done.error();
    share_ *= kKernelBackoff;
    binds_no_more_ = false;
    kernels_then_ = kernels;
    held_.clear();
    frame_.release_buffers();
    done = draw_once(objects, eyes, options, take_out);
  }
  if (done && ended) log_warn("%s (%s)", notice().c_str(), ended->message.c_str());
  return done;
}

Result<void> VulkanSplatRenderer::draw_once(std::span<const RenderedObject> objects,
                                            std::span<const Camera> eyes, const RenderOptions& options,
                                            const TakeOut& take_out) {
  LIVEGS_ASSERT(eyes.size() == 1 || eyes.size() == 2);
  LIVEGS_ASSERT(eyes.front().width == eyes.back().width && eyes.front().height == eyes.back().height);
  // Submits commands left by a failed picture, before anything they refer to is changed.
  if (auto done = backend_->submit(); !done) return done;
  const VulkanCommands::Traffic before = vulkan_commands(*backend_)->traffic();
  step_began_ns_ = now_ns();
  const auto timed = [&](Result<void> done, double& ms) -> Result<void> {
    if (!done) return done;
    auto passed = step_ms();
    if (!passed) return passed.error();
    ms = *passed;
    return {};
  };
  if (auto done = timed(hold(objects), times_.upload_ms); !done) return done;
  std::vector<FrameSplats::Object> kernels;
  for (const RenderedObject& object : objects)
    kernels.push_back(frame_object(object.drawn.object_id, held_.find(object.drawn.object_id)->second));
  const FrameSplats::Options splats{options.order,         options.max_sh_degree,
                                    options.max_radius_px, options.min_contribution_px,
                                    options.shadows,       options.environments};
  const auto project = [&]() -> Result<void> {
    if (auto done = frame_.prepare(kernels, eyes, splats); !done) return done;
    if (auto done = timer_.begin(); !done) return done;
    if (auto done = timer_.mark(DevicePass::Project); !done) return done;
    if (auto done = frame_.project_prepared(kernels, splats); !done) return done;
    return timer_.mark(DevicePass::None);
  };
  // Records a pass between two timestamps.
  const auto between_moments = [&](DevicePass pass, auto&& record) -> Result<void> {
    if (auto done = timer_.mark(pass); !done) return done;
    if (auto done = record(); !done) return done;
    return timer_.mark(DevicePass::None);
  };
  if (auto done = timed(project(), times_.project_ms); !done) return done;
  if (auto done = timed(between_moments(DevicePass::Sort, [&] { return frame_.sort(); }), times_.sort_ms);
      !done)
    return done;
  const auto paint = [&]() -> Result<void> {
    const auto draws = [&] {
      return pass_->paint(frame_, eyes[0].width, eyes[0].height, static_cast<int>(eyes.size()));
    };
    if (auto done = between_moments(DevicePass::Draw, draws); !done) return done;
    const auto resolves = [&] { return pass_->resolve(options.background); };
    if (auto done = between_moments(DevicePass::Resolve, resolves); !done) return done;
    return take_out();
  };
  if (auto done = timed(paint(), times_.draw_ms); !done) return done;
  const VulkanCommands::Traffic& now = vulkan_commands(*backend_)->traffic();
  times_.uploaded_bytes = now.uploaded_bytes - before.uploaded_bytes;
  times_.submissions = now.submissions - before.submissions;
  times_.dispatches = now.dispatches - before.dispatches;
  times_.barriers = now.barriers - before.barriers;
  times_.eyes_a_draw = pass_->eyes_a_draw();
  times_.device.reset();
  if (std::array<double, 6> ms{}; timer_.read(ms)) {
    const auto of = [&](DevicePass pass) { return ms[static_cast<size_t>(pass)]; };
    times_.device = DeviceTimes{of(DevicePass::Skin), of(DevicePass::Project), of(DevicePass::Sort),
                                of(DevicePass::Draw), of(DevicePass::Resolve)};
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<SplatRenderer>> create_vulkan_renderer(std::shared_ptr<VulkanDevice> device,
                                                              const VulkanRendererOptions& options) {
  auto backend = create_vulkan_backend(device);
  if (!backend) return backend.error();
  DrawMethod method = options.method;
  if (method == DrawMethod::Auto) {
    auto faster = faster_method(device);
    if (!faster) return faster.error();
    method = *faster;
  }
  std::unique_ptr<SplatPass> pass;
  if (method == DrawMethod::Tiles) {
    pass = SplatPass::create_tiles(**backend, device->handles(), options.read_blended);
  } else {
    auto quads = SplatPass::create_quads(**backend, device->handles(), options.precision);
    if (!quads) return quads.error();
    pass = *std::move(quads);
  }
  return Result<std::unique_ptr<SplatRenderer>>(std::make_unique<VulkanSplatRenderer>(
      std::move(device), *std::move(backend), std::move(pass), options));
}

}  // namespace livegs
