// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/splat_pass.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "compute/vulkan_commands.h"
#include "core/assert.h"
#include "core/log.h"
#include "draw_splats_frag.spv.h"
#include "draw_splats_vert.spv.h"
#include "render/vulkan/draw_pipeline.h"
#include "render/vulkan/draw_splats_layout.h"
#include "render/vulkan/eye_images.h"
#include "resolve_eyes_frag.spv.h"
#include "resolve_eyes_vert.spv.h"
#include "splat/passes/device_kernels.h"

namespace livegs {
namespace {

class QuadSplatPass final : public SplatPass {
 public:
  QuadSplatPass(Backend& backend, VulkanCommands& commands, const VulkanHandles& handles)
      : backend_(backend), commands_(commands), handles_(handles), draw_(handles), resolve_(handles) {}
  ~QuadSplatPass() override {
    (void)backend_.submit();
  }  // recorded commands must not outlive the objects they name

  Result<void> create(BlendPrecision precision);
  Result<void> paint(const FrameSplats& frame, int width, int height, int eyes) override;
  int eyes_a_draw() const override { return multiview_works_.value_or(true) ? images_->eyes() : 1; }
  Result<void> resolve(const Eigen::Vector3f& background) override;
  Result<void> read(std::vector<Image>& images) override;
  Result<void> copy_into(const DeviceImage& image) override;
  Result<void> read_blended(std::vector<Image>& images) override;

 private:
  void transition(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) {
    change_layout(handles_.vk, commands, image, images_->eyes(), from, to);
  }
  void begin_rendering(VkCommandBuffer commands, VkImageView view, int eyes, VkAttachmentLoadOp load);
  void bind(VkCommandBuffer commands, const DrawPipeline& pipeline, int eyes);
  Result<void> make_images(int width, int height, int eyes);
  Result<void> try_multiview();

  Backend& backend_;
  VulkanCommands& commands_;
  const VulkanHandles& handles_;
  VkFormat blended_format_ = VK_FORMAT_R16G16B16A16_SFLOAT;
  DrawPipeline draw_, resolve_;
  std::unique_ptr<EyeImages> images_;
  std::optional<bool> multiview_works_;  // unset until two eyes were requested
};

bool can_blend(const VulkanHandles& handles, VkFormat format) {
  VkFormatProperties properties;
  handles.vk.GetPhysicalDeviceFormatProperties(handles.physical_device, format, &properties);
  constexpr VkFormatFeatureFlags kWanted =
      VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
  return (properties.optimalTilingFeatures & kWanted) == kWanted;
}

Result<void> QuadSplatPass::create(BlendPrecision precision) {
  const bool software = handles_.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  const bool full = precision == BlendPrecision::Full || (precision == BlendPrecision::Auto && software);
  if (full && can_blend(handles_, VK_FORMAT_R32G32B32A32_SFLOAT))
    blended_format_ = VK_FORMAT_R32G32B32A32_SFLOAT;
  DrawPipeline::Description draw;
  draw.vertex_spirv = draw_splats_vert_spirv;
  draw.fragment_spirv = draw_splats_frag_spirv;
  draw.format = blended_format_;
  draw.front_to_back = true;
  draw.binding_count = 1 + 2 * FrameSplats::kRowParts;
  draw.constants_bytes = sizeof(DrawSplatsConstants);
  if (auto made = draw_.create(draw); !made)
    return Error{made.error().code, "draw_splats: " + made.error().message};
  DrawPipeline::Description resolve;
  resolve.vertex_spirv = resolve_eyes_vert_spirv;
  resolve.fragment_spirv = resolve_eyes_frag_spirv;
  resolve.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  resolve.format = EyeImages::kResolvedFormat;
  resolve.binding_count = 1;
  resolve.binding_type = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
  resolve.binding_stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  resolve.constants_bytes = sizeof(ResolveConstants);
  resolve.constants_stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  if (auto made = resolve_.create(resolve); !made)
    return Error{made.error().code, "resolve_eyes: " + made.error().message};
  return {};
}

void QuadSplatPass::begin_rendering(VkCommandBuffer commands, VkImageView view, int eyes,
                                    VkAttachmentLoadOp load) {
  const VkExtent2D extent{static_cast<uint32_t>(images_->width()), static_cast<uint32_t>(images_->height())};
  auto attachment = vulkan_info<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  attachment.imageView = view;
  attachment.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  attachment.loadOp = load;  // cleared to zero: no coverage
  attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  auto info = vulkan_info<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea.extent = extent;
  info.layerCount = 1;
  info.viewMask = (1u << eyes) - 1;
  info.colorAttachmentCount = 1;
  info.pColorAttachments = &attachment;
  handles_.vk.CmdBeginRendering(commands, &info);
  const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
  const VkRect2D scissor{{0, 0}, extent};
  handles_.vk.CmdSetViewport(commands, 0, 1, &viewport);
  handles_.vk.CmdSetScissor(commands, 0, 1, &scissor);
}

void QuadSplatPass::bind(VkCommandBuffer commands, const DrawPipeline& pipeline, int eyes) {
  const VkDescriptorSet set = pipeline.set();
  handles_.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.pipeline(eyes));
  handles_.vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.layout(), 0, 1, &set,
                                    0, nullptr);
}

Result<void> QuadSplatPass::make_images(int width, int height, int eyes) {
  if (images_ && images_->is_of(width, height, eyes)) return {};
  if (auto done = backend_.submit(); !done) return done;
  images_.reset();
  auto made = EyeImages::create(handles_, blended_format_, width, height, eyes);
  if (!made) return Error{made.error().code, "eye images: " + made.error().message};
  images_ = *std::move(made);
  return {};
}

// Draws one kernel over a background, once for both eyes together and once for each eye, and compares. Mesa's
// lavapipe 22.3.6 draws every fully covered 4x4 block to the first eye, whatever the view index. NVIDIA's
// driver 580 draws kernels wrong in the second eye; the cause is not known. On such devices the eyes are
// drawn one after the other.
Result<void> QuadSplatPass::try_multiview() {
  constexpr int kSide = 80;  // px, more than one of lavapipe's tiles
  constexpr float kRadius_m = 0.05f, kEyeDistance_m = 0.1;
  constexpr float kVariance_m2 = kRadius_m * kRadius_m;
  GaussianAsset asset;
  asset.positions = {Eigen::Vector3f::Zero()};
  asset.log_scales = {Eigen::Vector3f::Constant(std::log(kRadius_m))};
  asset.rotations = {Eigen::Quaternionf::Identity()};
  asset.sh_dc = {{1.0f, 0.0f, -1.0f}};
  asset.opacity_logits = {2.0f};
  const PosedKernels posed{
      asset.positions, {{kVariance_m2, 0, 0, kVariance_m2, 0, kVariance_m2}}, asset.rotations};
  auto kernels = DeviceKernels::create(backend_, asset);
  if (!kernels) return kernels.error();
  if (auto done = kernels->pose(posed); !done) return done;
  std::array<Camera, 2> eyes;
  for (int e = 0; e < 2; ++e) {
    eyes[e] = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.5, kSide, kSide);
    eyes[e].world_from_camera.position_m.x() = (e - 0.5) * kEyeDistance_m;
  }
  const FrameSplats::Object object{&*kernels, {}, 0};
  FrameSplats frame(backend_);
  if (auto done = frame.project({&object, 1}, eyes, {}); !done) return done;
  if (auto done = frame.sort(); !done) return done;
  std::array<std::vector<Image>, 2> pictures;  // of the eyes apart, and of both together
  for (const bool together : {false, true}) {
    multiview_works_ = together;
    auto done = paint(frame, kSide, kSide, 2);
    if (done) done = resolve({1.0f, 0.5f, 0.25f});
    if (done) done = read(pictures[together]);
    if (!done) {
      multiview_works_.reset();  // not known
      return done;
    }
  }
  for (int e = 0; e < 2; ++e)
    *multiview_works_ = *multiview_works_ && pictures[1][e].pixels == pictures[0][e].pixels;
  if (!*multiview_works_)
    log_info("%s: multiview gives wrong pictures; the eyes are drawn separately", handles_.name.c_str());
  return {};
}

Result<void> QuadSplatPass::paint(const FrameSplats& frame, int width, int height, int eyes) {
  LIVEGS_ASSERT(width > 0 && height > 0 && (eyes == 1 || eyes == 2));
  const auto most = static_cast<int>(handles_.properties.limits.maxImageDimension2D);
  if (width > most || height > most) {
    return Error{ErrorCode::TooLarge, "picture: " + std::to_string(width) + "x" + std::to_string(height) +
                                          " px exceed the limit of " + handles_.name + ", " +
                                          std::to_string(most) + " px per side; draw a smaller picture"};
  }
  if (eyes == 2 && !multiview_works_) {
    if (auto tried = try_multiview(); !tried) return tried;
  }
  if (auto made = make_images(width, height, eyes); !made) return made;
  const VulkanFunctions& vk = handles_.vk;
  // The last use of the sets has finished: taking out a picture waits for it, and the renderer submits any
  // remaining commands.
  std::array<VkDescriptorBufferInfo, 1 + 2 * FrameSplats::kRowParts> buffers;
  buffers[0] = {commands_.buffer_of(frame.order()), 0, VK_WHOLE_SIZE};
  for (int e = 0; e < 2; ++e) {
    for (int part = 0; part < FrameSplats::kRowParts; ++part)
      buffers[1 + e * FrameSplats::kRowParts + part] = {commands_.buffer_of(frame.rows(e, part)), 0,
                                                        VK_WHOLE_SIZE};
  }
  auto write = vulkan_info<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = draw_.set();
  write.descriptorCount = buffers.size();
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = buffers.data();
  vk.UpdateDescriptorSets(handles_.device, 1, &write, 0, nullptr);

  auto commands = commands_.record();
  if (!commands) return commands.error();
  transition(*commands, images_->blended(), VK_IMAGE_LAYOUT_UNDEFINED,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  const int count = eyes_a_draw();
  for (int first = 0; first < eyes; first += count) {
    begin_rendering(*commands, images_->blended_target(first, count), count, VK_ATTACHMENT_LOAD_OP_CLEAR);
    bind(*commands, draw_, count);
    const DrawSplatsConstants constants{static_cast<float>(width), static_cast<float>(height),
                                        static_cast<uint32_t>(first), frame.part_rows()};
    vk.CmdPushConstants(*commands, draw_.layout(), VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof constants,
                        &constants);
    vk.CmdDrawIndirect(*commands, commands_.buffer_of(frame.counted()), 0, 1, sizeof(VkDrawIndirectCommand));
    vk.CmdEndRendering(*commands);
  }
  return {};
}

Result<void> QuadSplatPass::resolve(const Eigen::Vector3f& background) {
  LIVEGS_ASSERT(images_ != nullptr);
  const VulkanFunctions& vk = handles_.vk;
  const VkDescriptorImageInfo image{VK_NULL_HANDLE, images_->blended_view(),
                                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  auto write = vulkan_info<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = resolve_.set();
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
  write.pImageInfo = &image;
  vk.UpdateDescriptorSets(handles_.device, 1, &write, 0, nullptr);

  auto commands = commands_.record();
  if (!commands) return commands.error();
  transition(*commands, images_->blended(), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
             VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  transition(*commands, images_->resolved(), VK_IMAGE_LAYOUT_UNDEFINED,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  const int count = eyes_a_draw();
  for (int first = 0; first < images_->eyes(); first += count) {
    begin_rendering(*commands, images_->resolved_target(first, count), count,
                    VK_ATTACHMENT_LOAD_OP_DONT_CARE);
    bind(*commands, resolve_, count);
    const ResolveConstants constants{background.x(), background.y(), background.z(),
                                     static_cast<uint32_t>(first)};
    vk.CmdPushConstants(*commands, resolve_.layout(), VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                        &constants);
    vk.CmdDraw(*commands, 3, 1, 0, 0);
    vk.CmdEndRendering(*commands);
  }
  return {};
}

Result<void> QuadSplatPass::read(std::vector<Image>& images) {
  LIVEGS_ASSERT(images_ != nullptr);
  auto commands = commands_.record();
  if (!commands) return commands.error();
  transition(*commands, images_->resolved(), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  images_->copy_resolved(*commands);
  transition(*commands, images_->resolved(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  if (auto recorded = commands_.record(); !recorded)
    return recorded.error();  // the barrier that the host waits for
  if (auto done = backend_.submit(); !done) return done;
  images_->read_resolved(images);
  return {};
}

Result<void> QuadSplatPass::copy_into(const DeviceImage& image) {
  LIVEGS_ASSERT(images_ && image.layers == images_->eyes() && image.width >= images_->width() &&
                image.height >= images_->height());
  auto commands = commands_.record();
  if (!commands) return commands.error();
  transition(*commands, images_->resolved(), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  images_->blit_resolved(*commands, image);
  transition(*commands, images_->resolved(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  return backend_.submit();
}

Result<void> QuadSplatPass::read_blended(std::vector<Image>& images) {
  LIVEGS_ASSERT(images_ != nullptr);
  auto commands = commands_.record();
  if (!commands) return commands.error();
  transition(*commands, images_->blended(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  images_->copy_blended(*commands);
  transition(*commands, images_->blended(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
             VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  if (auto recorded = commands_.record(); !recorded) return recorded.error();
  if (auto done = backend_.submit(); !done) return done;
  images_->read_blended(images);
  return {};
}

}  // namespace

Result<std::unique_ptr<SplatPass>> SplatPass::create_quads(Backend& backend, const VulkanHandles& handles,
                                                           BlendPrecision precision) {
  VulkanCommands* commands = vulkan_commands(backend);
  LIVEGS_ASSERT(commands != nullptr);
  if (!handles.draws) {
    return Error{ErrorCode::Unavailable,
                 "vulkan: " + handles.name + " supports compute but not graphics; draw by tiles"};
  }
  auto pass = std::make_unique<QuadSplatPass>(backend, *commands, handles);
  if (auto made = pass->create(precision); !made) return made.error();
  return Result<std::unique_ptr<SplatPass>>(std::move(pass));
}

}  // namespace livegs
