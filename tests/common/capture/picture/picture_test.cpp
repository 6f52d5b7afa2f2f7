// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "capture/picture/picture_file.h"
#include "capture/picture_store.h"
#include "common/capture/picture/jpeg_bytes.h"
#include "core/file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// Smooth colours, so that the loss of JPEG is small.
Image gradient_image(int width, int height) {
  Image image;
  image.width = width;
  image.height = height;
  image.pixels.resize(size_t{4} * static_cast<size_t>(width * height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float* pixel = image.at(x, y);
      pixel[0] = 0.2f + 0.6f * static_cast<float>(x) / static_cast<float>(width);
      pixel[1] = 0.2f + 0.6f * static_cast<float>(y) / static_cast<float>(height);
      pixel[2] = 0.5f;
      pixel[3] = 1;
    }
  }
  return image;
}

Capture capture_of(const ScratchFolder& folder, const std::string& picture, int width, int height) {
  Capture capture;
  capture.folder = folder.path();
  CapturedView view;
  view.name = picture;
  view.picture = folder / picture;
  view.camera.width = width;
  view.camera.height = height;
  view.camera.focal_x_px = view.camera.focal_y_px = width;
  view.camera.centre_x_px = 0.5 * width;
  view.camera.centre_y_px = 0.5 * height;
  capture.views.push_back(view);
  return capture;
}

}  // namespace

TEST(PictureFile, JpegIsReadWithItsOrientation) {
  const Image image = gradient_image(40, 24);
  for (int orientation = 0; orientation <= 8; ++orientation) {
    const auto picture = decode_picture(encode_jpeg(image, orientation));
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->orientation, std::max(1, orientation));
    EXPECT_EQ(picture->image.width, 40);
    EXPECT_GT(psnr_db(picture->image, image), 38);  // quality 98
  }
}

TEST(PictureFile, DamagedJpegIsRefused) {
  const std::vector<std::byte> good = encode_jpeg(gradient_image(40, 24), 6);
  for (size_t length = 0; length < good.size(); length += 7)
    EXPECT_FALSE(decode_picture(std::span(good).first(length))) << length;
  for (size_t at = 0; at < good.size(); at += 3) {
    std::vector<std::byte> changed = good;
    changed[at] = ~changed[at];
    (void)decode_picture(changed);
  }
}

// Tables of EXIF: where the pixel (0, 0) of the stored picture is in the upright one.
TEST(PictureFile, UprightPicturesFollowTheTable) {
  Image stored = gradient_image(3, 2);
  stored.at(0, 0)[0] = 1;
  const auto marked = [](const Image& image) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (image.at(x, y)[0] == 1) return std::pair(x, y);
      }
    }
    return std::pair(-1, -1);
  };
  const std::pair<int, int> expected[9] = {{0, 0}, {0, 0}, {2, 0}, {2, 1}, {0, 1},
                                           {0, 0}, {1, 0}, {1, 2}, {0, 2}};
  for (int orientation = 1; orientation <= 8; ++orientation)
    EXPECT_EQ(marked(turn_upright(stored, orientation)), expected[orientation]) << orientation;
}

TEST(PictureFile, DamagedExifHasNoOrientation) {
  std::vector<std::byte> exif(32, std::byte{0xff});
  EXPECT_EQ(exif_orientation(exif), 1);
  const char start[] = {'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0};
  std::memcpy(exif.data(), start, sizeof start);
  EXPECT_EQ(exif_orientation(exif), 1);
  EXPECT_EQ(exif_orientation({}), 1);
}

TEST(PictureStore, ReducesToTheMeanOfThePixels) {
  ScratchFolder folder;
  Image image = gradient_image(40, 24);
  ASSERT_TRUE(write_png(folder / "a.png", image).has_value());
  const Capture capture = capture_of(folder, "a.png", 40, 24);
  PictureOptions options;
  options.longest_px = 20;
  PictureStore store(capture, options);
  const auto picture = store.picture(0);
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_EQ((*picture)->width, 20);
  EXPECT_EQ((*picture)->height, 12);
  EXPECT_TRUE((*picture)->opaque);
  EXPECT_TRUE((*picture)->counts.empty());
  EXPECT_EQ(store.camera(0).focal_x_px, 20.0);
  EXPECT_EQ(store.camera(0).centre_y_px, 6.0);
  const std::vector<uint8_t> whole = rgb_bytes(image);
  for (size_t y = 0; y < 12; ++y) {
    for (size_t x = 0; x < 20; ++x) {
      double sum = 0;
      for (size_t k = 0; k < 4; ++k) sum += whole[3 * ((2 * y + k / 2) * 40 + 2 * x + k % 2)];
      EXPECT_NEAR((*picture)->rgba[4 * (y * 20 + x)], sum / 4, 0.51);
    }
  }
}

constexpr LensDistortion kLens = {0.2, -0.05, 0.01, -0.02};

// A photo of 80 x 60 pixels with a focal length of 80, taken through a distorting lens: the brightness of
// each pixel is that of the scene at the slopes of its ray.
Image distorted_photo(const std::function<double(double x, double y)>& scene) {
  Image image = gradient_image(80, 60);
  for (int py = 0; py < 60; ++py) {
    for (int px = 0; px < 80; ++px) {
      // The undistorted slope of a distorted pixel, by fixed-point iteration.
      const double xd = (px + 0.5 - 40) / 80, yd = (py + 0.5 - 30) / 80;
      double x = xd, y = yd;
      for (int i = 0; i < 100; ++i) {
        const double r = x * x + y * y, radial = 1 + kLens.k1 * r + kLens.k2 * r * r;
        x = (xd - 2 * kLens.p1 * x * y - kLens.p2 * (r + 2 * x * x)) / radial;
        y = (yd - kLens.p1 * (r + 2 * y * y) - 2 * kLens.p2 * x * y) / radial;
      }
      for (int c = 0; c < 3; ++c) image.at(px, py)[c] = static_cast<float>(scene(x, y));
    }
  }
  return image;
}

// Compares the pixels of the undistorted photo that are `margin_px` or more from its edges with the scene.
void expect_undistorted(const std::function<double(double x, double y)>& scene, int margin_px,
                        double tolerance) {
  ScratchFolder folder;
  Capture capture = capture_of(folder, "a.png", 80, 60);
  capture.views[0].distortion = kLens;
  ASSERT_TRUE(write_png(folder / "a.png", distorted_photo(scene)).has_value());
  PictureStore store(capture, {});
  const auto picture = store.picture(0);
  ASSERT_TRUE(picture) << picture.error().message;
  size_t counted = 0;
  for (int py = margin_px; py < 60 - margin_px; ++py) {
    for (int px = margin_px; px < 80 - margin_px; ++px) {
      const auto pixel = static_cast<size_t>(py * 80 + px);
      if (!(*picture)->counts.empty() && (*picture)->counts[pixel] == 0) continue;
      ++counted;
      EXPECT_NEAR((*picture)->rgba[4 * pixel] / 255.0, scene((px + 0.5 - 40) / 80, (py + 0.5 - 30) / 80),
                  tolerance);
    }
  }
  const auto compared = static_cast<size_t>((80 - 2 * margin_px) * (60 - 2 * margin_px));
  EXPECT_GT(counted, compared * 5 / 8);
  if (margin_px == 0) EXPECT_LT(counted, compared);  // the corners lie outside the photo
}

// Two roundings are 0.004. Half a pixel at the edge of the photo has no neighbour: 0.3 * 4 / 80 / 2.
TEST(PictureStore, DistortionIsRemoved) {
  expect_undistorted([](double x, double y) { return 0.5 + 0.3 * std::sin(3 * x) * std::cos(4 * y); }, 0,
                     0.0115);
}

// Waves of five pixels along one axis. Halfway between two pixels cubic interpolation keeps
// 9/8 cos(pi / 5) - 1/8 cos(3 pi / 5) = 0.949 of their amplitude, linear interpolation only 0.809. With the
// two roundings: 0.051 * 0.3 + 0.004. Towards the corners the lens shortens the waves by up to a twelfth.
TEST(PictureStore, RemovingDistortionKeepsFineDetail) {
  const double wave = 2 * M_PI / (5.0 / 80);
  expect_undistorted([&](double x, double) { return 0.5 + 0.3 * std::cos(wave * x); }, 6, 0.024);
  expect_undistorted([&](double, double y) { return 0.5 + 0.3 * std::cos(wave * y); }, 6, 0.024);
}

TEST(PictureStore, APhotoIsTurnedOnlyIfItsPoseHasTheTurnedSize) {
  ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder / "a.jpg", encode_jpeg(gradient_image(40, 24), 6)).has_value());
  const Capture stored = capture_of(folder, "a.jpg", 40, 24), turned = capture_of(folder, "a.jpg", 24, 40);
  PictureStore as_stored(stored, {}), upright(turned, {});
  const auto a = as_stored.picture(0);
  ASSERT_TRUE(a);
  EXPECT_LT((*a)->rgba[0], (*a)->rgba[4 * 39]);  // red rises to the right
  const auto b = upright.picture(0);
  ASSERT_TRUE(b) << b.error().message;
  EXPECT_NEAR((*b)->rgba[0], (*b)->rgba[4 * 23], 6);
  EXPECT_LT((*b)->rgba[0], (*b)->rgba[4 * 24 * 39]);  // and downwards after a quarter turn
}

TEST(PictureStore, MemoryIsBounded) {
  ScratchFolder folder;
  Capture capture = capture_of(folder, "a.png", 40, 24);
  ASSERT_TRUE(write_png(folder / "a.png", gradient_image(40, 24)).has_value());
  for (int i = 0; i < 9; ++i) capture.views.push_back(capture.views[0]);
  PictureOptions options;
  options.max_bytes = 3 * 40 * 24 * 4;
  PictureStore store(capture, options);
  ASSERT_TRUE(store.check_all().has_value());
  EXPECT_LE(store.bytes_in_memory(), options.max_bytes);
  for (size_t i = 0; i < 10; ++i) ASSERT_TRUE(store.picture(i));
  EXPECT_LE(store.bytes_in_memory(), options.max_bytes);
}

TEST(PictureStore, MasksAreIgnoredUnlessAskedFor) {
  ScratchFolder folder;
  Capture capture = capture_of(folder, "a.png", 40, 24);
  ASSERT_TRUE(write_png(folder / "a.png", gradient_image(40, 24)).has_value());
  Image mask = gradient_image(40, 24);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 40; ++x) {
      for (int c = 0; c < 3; ++c) mask.at(x, y)[c] = x < 10 ? 0.0f : 2.0f / 255;
    }
  }
  ASSERT_TRUE(write_png(folder / "m.png", mask).has_value());
  capture.views[0].mask = folder / "m.png";
  EXPECT_TRUE((*PictureStore(capture, {}).picture(0))->counts.empty());
  PictureOptions options;
  options.ignore_masked = true;
  const auto masked = PictureStore(capture, options).picture(0);
  ASSERT_TRUE(masked);
  EXPECT_EQ((*masked)->counts[9], 0);
  EXPECT_EQ((*masked)->counts[10], 255);
  ASSERT_TRUE(write_png(folder / "m.png", gradient_image(20, 24)).has_value());
  const auto refused = PictureStore(capture, options).picture(0);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("but its photo is 40 x 24"), std::string::npos);
}

TEST(PictureStore, UnusablePhotosAreRefusedWithOneLine) {
  ScratchFolder folder;
  Image black = gradient_image(40, 24);
  for (size_t i = 0; i < black.pixels.size(); i += 4)
    black.pixels[i] = black.pixels[i + 1] = black.pixels[i + 2] = 0;
  ASSERT_TRUE(write_png(folder / "black.png", black).has_value());
  ASSERT_TRUE(write_png(folder / "good.png", gradient_image(40, 24)).has_value());
  folder.write("text.png", "not a picture");
  const auto error_of = [&](const std::string& name, int width, int height) {
    const Capture capture = capture_of(folder, name, width, height);
    const auto checked = PictureStore(capture, {}).check_all();
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_NE(error_of("black.png", 40, 24).find("is black"), std::string::npos);
  EXPECT_NE(error_of("text.png", 40, 24).find("neither a PNG nor a JPEG"), std::string::npos);
  EXPECT_NE(error_of("good.png", 24, 40).find("its pose is of 24 x 40"), std::string::npos);
  EXPECT_EQ(error_of("good.png", 20, 12), "");  // half of the size in the pose file
  Capture two = capture_of(folder, "black.png", 40, 24);
  two.views.push_back(two.views[0]);
  EXPECT_NE(PictureStore(two, {}).check_all().error().message.find("2 of 2 photos"), std::string::npos);
}

}  // namespace livegs
