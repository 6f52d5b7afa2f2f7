// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/eye_images.h"

#include <algorithm>
#include <cstring>

#include "core/parallel_for.h"
#include "splat/half_float.h"

namespace livegs {

void change_layout(const VulkanFunctions& vk, VkCommandBuffer commands, VkImage image, int layers,
                   VkImageLayout from, VkImageLayout to) {
  auto barrier = vulkan_info<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, static_cast<uint32_t>(layers)};
  auto dependency = vulkan_info<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &barrier;
  vk.CmdPipelineBarrier2(commands, &dependency);
}

Result<std::unique_ptr<EyeImages>> EyeImages::create(const VulkanHandles& handles, VkFormat blended_format,
                                                     int width, int height, int eyes) {
  std::unique_ptr<EyeImages> images(new EyeImages(handles, blended_format, width, height, eyes));
  constexpr VkImageUsageFlags kBoth = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  if (blended_format == VK_FORMAT_UNDEFINED) {
    if (auto made =
            images->make_layers(kResolvedFormat, kBoth | VK_IMAGE_USAGE_TRANSFER_DST_BIT, images->resolved_);
        !made)
      return made.error();
    return Result<std::unique_ptr<EyeImages>>(std::move(images));
  }
  if (auto made = images->make_layers(blended_format, kBoth | VK_IMAGE_USAGE_SAMPLED_BIT, images->blended_);
      !made)
    return made.error();
  if (auto made = images->make_layers(kResolvedFormat, kBoth, images->resolved_); !made) return made.error();
  const VkDeviceSize bytes = images->blended_pixel_bytes() * static_cast<size_t>(width) * height * eyes;
  if (auto made = images->readback_.create(handles, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT); !made)
    return made.error();
  return Result<std::unique_ptr<EyeImages>>(std::move(images));
}

EyeImages::~EyeImages() {
  const VulkanFunctions& vk = handles_.vk;
  for (const Layers& layers : {blended_, resolved_}) {
    vk.DestroyImageView(handles_.device, layers.view, nullptr);
    for (const VkImageView view : layers.of_eye) vk.DestroyImageView(handles_.device, view, nullptr);
    vk.DestroyImage(handles_.device, layers.image, nullptr);
  }
}

Result<void> EyeImages::make_layers(VkFormat format, VkImageUsageFlags usage, Layers& layers) {
  const VulkanFunctions& vk = handles_.vk;
  auto info = vulkan_info<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {static_cast<uint32_t>(width_), static_cast<uint32_t>(height_), 1};
  info.mipLevels = 1;
  info.arrayLayers = static_cast<uint32_t>(eyes_);
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = usage;
  if (const VkResult made = vk.CreateImage(handles_.device, &info, nullptr, &layers.image);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateImage", made);
  }
  VkMemoryRequirements needs;
  vk.GetImageMemoryRequirements(handles_.device, layers.image, &needs);
  auto range = memory_.allocate(needs);
  if (!range) return range.error();
  if (const VkResult bound =
          vk.BindImageMemory(handles_.device, layers.image, memory_.memory_of(*range), range->offset);
      bound != VK_SUCCESS) {
    return vulkan_error("vkBindImageMemory", bound);
  }
  for (int e = -1; e < eyes_; ++e) {
    auto view = vulkan_info<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view.image = layers.image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    view.format = format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, static_cast<uint32_t>(std::max(e, 0)),
                             static_cast<uint32_t>(e < 0 ? eyes_ : 1)};
    VkImageView& made_view = e < 0 ? layers.view : layers.of_eye[e];
    if (const VkResult made = vk.CreateImageView(handles_.device, &view, nullptr, &made_view);
        made != VK_SUCCESS) {
      return vulkan_error("vkCreateImageView", made);
    }
  }
  return {};
}

void EyeImages::copy(VkCommandBuffer commands, VkImage image) {
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, static_cast<uint32_t>(eyes_)};
  region.imageExtent = {static_cast<uint32_t>(width_), static_cast<uint32_t>(height_), 1};
  handles_.vk.CmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, readback_.buffer(),
                                   1, &region);
}

void EyeImages::blit_resolved(VkCommandBuffer commands, const DeviceImage& image) const {
  change_layout(handles_.vk, commands, image.image, eyes_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  VkImageBlit region{};
  region.srcSubresource =
      region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, static_cast<uint32_t>(eyes_)};
  region.srcOffsets[1] = region.dstOffsets[1] = {width_, height_, 1};
  handles_.vk.CmdBlitImage(commands, resolved_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image.image,
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region, VK_FILTER_NEAREST);
  change_layout(handles_.vk, commands, image.image, eyes_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
}

void EyeImages::copy_resolved(VkCommandBuffer commands) { copy(commands, resolved_.image); }
void EyeImages::copy_blended(VkCommandBuffer commands) { copy(commands, blended_.image); }

namespace {

// Reads one image per layer; `to_floats` converts `count` values from `at` on.
template <class ToFloats>
void read_layers(int width, int height, int eyes, std::vector<Image>& images, const ToFloats& to_floats) {
  images.resize(static_cast<size_t>(eyes));
  const size_t row = size_t{4} * width;
  for (size_t e = 0; e < images.size(); ++e) {
    Image& image = images[e];
    image.width = width;
    image.height = height;
    image.pixels.resize(row * height);
    parallel_for(static_cast<size_t>(height), 32, [&](size_t begin, size_t end) {
      to_floats((e * height + begin) * row, (end - begin) * row, image.pixels.data() + begin * row);
    });
  }
}

}  // namespace

void EyeImages::read_resolved(std::vector<Image>& images) const {
  read_layers(width_, height_, eyes_, images, [&](size_t at, size_t count, float* values) {
    for (size_t i = 0; i < count; ++i)
      values[i] = static_cast<float>(std::to_integer<int>(readback_.bytes()[at + i])) / 255.0f;
  });
}

void EyeImages::read_blended(std::vector<Image>& images) const {
  read_layers(width_, height_, eyes_, images, [&](size_t at, size_t count, float* values) {
    if (blended_format_ == VK_FORMAT_R32G32B32A32_SFLOAT) {
      std::memcpy(values, readback_.bytes() + 4 * at, 4 * count);
      return;
    }
    for (size_t i = 0; i < count; ++i) {
      uint16_t half;
      std::memcpy(&half, readback_.bytes() + 2 * (at + i), 2);
      values[i] = float_of_half(half);
    }
  });
}

}  // namespace livegs
