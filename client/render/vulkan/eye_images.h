// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "compute/device_image.h"
#include "compute/vulkan_handles.h"
#include "compute/vulkan_memory.h"
#include "splat/image.h"

namespace livegs {

// Records a full barrier that changes the layout of all layers; images change it only a few times per frame.
void change_layout(const VulkanFunctions& vk, VkCommandBuffer commands, VkImage image, int layers,
                   VkImageLayout from, VkImageLayout to);

// Two images with one layer per eye, the blend target and the resolve target, and a readback buffer. Or the
// resolve target alone, for copies.
class EyeImages {
 public:
  // blended_format: RGBA with 16- or 32-bit floats; undefined: the resolve target alone. width, height in px;
  // eyes: 1 or 2.
  static Result<std::unique_ptr<EyeImages>> create(const VulkanHandles& handles, VkFormat blended_format,
                                                   int width, int height, int eyes);
  ~EyeImages();
  EyeImages(const EyeImages&) = delete;
  EyeImages& operator=(const EyeImages&) = delete;

  static constexpr VkFormat kResolvedFormat = VK_FORMAT_R8G8B8A8_SRGB;

  bool is_of(int width, int height, int eyes) const {
    return width == width_ && height == height_ && eyes == eyes_;
  }
  int width() const { return width_; }
  int height() const { return height_; }
  int eyes() const { return eyes_; }
  VkImage blended() const { return blended_.image; }
  VkImageView blended_view() const { return blended_.view; }  // of all eyes
  VkImage resolved() const { return resolved_.image; }
  VkImageView resolved_view() const { return resolved_.view; }
  // Attachment of a draw to `count` eyes from `first` on: all of them, or one.
  VkImageView blended_target(int first, int count) const { return target(blended_, first, count); }
  VkImageView resolved_target(int first, int count) const { return target(resolved_, first, count); }

  // Records a copy of one of the images, which must be in TRANSFER_SRC_OPTIMAL.
  void copy_resolved(VkCommandBuffer commands);
  void copy_blended(VkCommandBuffer commands);
  // Records a blit of the resolved image, which must be in TRANSFER_SRC_OPTIMAL, to the top left of `image`;
  // the channel order may differ.
  void blit_resolved(VkCommandBuffer commands, const DeviceImage& image) const;
  // Reads the copy after the commands have finished. Blended image: premultiplied colour, coverage.
  void read_resolved(std::vector<Image>& images) const;
  void read_blended(std::vector<Image>& images) const;

 private:
  struct Layers {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkImageView of_eye[2]{};
  };

  EyeImages(const VulkanHandles& handles, VkFormat blended_format, int width, int height, int eyes)
      : handles_(handles),
        memory_(handles),
        blended_format_(blended_format),
        width_(width),
        height_(height),
        eyes_(eyes) {}
  VkImageView target(const Layers& layers, int first, int count) const {
    return count == eyes_ ? layers.view : layers.of_eye[first];
  }
  Result<void> make_layers(VkFormat format, VkImageUsageFlags usage, Layers& layers);
  void copy(VkCommandBuffer commands, VkImage image);
  size_t blended_pixel_bytes() const { return blended_format_ == VK_FORMAT_R32G32B32A32_SFLOAT ? 16 : 8; }

  const VulkanHandles& handles_;
  VulkanMemory memory_;  // images only, since some devices cannot share memory between images and buffers
  VkFormat blended_format_;
  int width_, height_, eyes_;
  Layers blended_, resolved_;
  HostBuffer readback_;
};

}  // namespace livegs
