// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "capture/capture.h"
#include "capture/read/pose_files.h"
#include "core/text/format_text.h"
#include "scratch_folder.h"
#include "splat/image.h"

namespace livegs {
namespace {

void write_photo(const std::filesystem::path& path, int width = 8, int height = 6) {
  std::filesystem::create_directories(path.parent_path());
  Image image;
  image.width = width;
  image.height = height;
  image.pixels.assign(size_t{4} * static_cast<size_t>(width * height), 0.5f);
  ASSERT_TRUE(write_png(path, image).has_value());
}

constexpr const char* kPose = "[[1,0,0,0.5],[0,0,-1,-2],[0,1,0,1],[0,0,0,1]]";

std::string frame(const std::string& name, const std::string& more = "") {
  return "{\"file_path\": \"" + name + "\", \"transform_matrix\": " + kPose + more + "}";
}

std::string transforms(const std::string& frames,
                       const std::string& head = "\"w\": 8, \"h\": 6, \"fl_x\": 10") {
  return "{" + head + ", \"frames\": [" + frames + "]}";
}

void append_bytes(std::string& bytes, const void* value, size_t size) {
  bytes.append(static_cast<const char*>(value), size);
}
template <class T>
void append_value(std::string& bytes, T value) {
  append_bytes(bytes, &value, sizeof value);
}

// A model of one OPENCV and one PINHOLE camera, three photos, two of them in a sub-folder, and three points.
struct BinaryModel {
  std::string cameras, images, points;
};
BinaryModel binary_model() {
  BinaryModel model;
  append_value<uint64_t>(model.cameras, 2);
  append_value<uint32_t>(model.cameras, 7);
  append_value<int32_t>(model.cameras, 4);
  append_value<uint64_t>(model.cameras, 8);
  append_value<uint64_t>(model.cameras, 6);
  for (double number : {10.0, 11.0, 4.0, 3.0, 0.1, -0.02, 0.001, 0.002}) append_value(model.cameras, number);
  append_value<uint32_t>(model.cameras, 2);
  append_value<int32_t>(model.cameras, 1);
  append_value<uint64_t>(model.cameras, 8);
  append_value<uint64_t>(model.cameras, 6);
  for (double number : {12.0, 13.0, 4.5, 3.5}) append_value(model.cameras, number);
  append_value<uint64_t>(model.images, 3);
  for (uint32_t i = 0; i < 3; ++i) {
    append_value<uint32_t>(model.images, i + 1);
    // A quarter turn about y, and a shift.
    for (double number : {std::sqrt(0.5), 0.0, std::sqrt(0.5), 0.0, 0.1, 0.2, 0.3 + i})
      append_value(model.images, number);
    append_value<uint32_t>(model.images, i == 0 ? 2 : 7);
    model.images += format_text("%s%u.png", i == 0 ? "" : "left/", i) + '\0';
    append_value<uint64_t>(model.images, i);
    for (uint32_t k = 0; k < i; ++k) {
      append_value(model.images, 1.5);
      append_value(model.images, 2.5);
      append_value<int64_t>(model.images, -1);
    }
  }
  const uint64_t photos[] = {0, 3, 2};  // the last point has too few
  append_value<uint64_t>(model.points, 3);
  for (uint64_t i = 0; i < 3; ++i) {
    append_value(model.points, i);
    for (double number : {1.0 + static_cast<double>(i), 2.0, 3.0}) append_value(model.points, number);
    for (uint8_t number : {uint8_t{255}, uint8_t{0}, uint8_t{51}}) append_value(model.points, number);
    append_value(model.points, 0.5);
    append_value(model.points, photos[i]);
    for (uint64_t k = 0; k < photos[i]; ++k) append_value<uint64_t>(model.points, 1);
  }
  return model;
}

void expect_colmap_model(const Capture& capture) {
  ASSERT_EQ(capture.views.size(), 3u);
  EXPECT_EQ(capture.views[0].name, "0.png");
  EXPECT_EQ(capture.views[2].name, "left/2.png");
  EXPECT_EQ(capture.views[0].camera.focal_y_px, 13.0);
  EXPECT_EQ(capture.views[0].camera.centre_x_px, 4.5);
  EXPECT_TRUE(capture.views[0].distortion.none());
  EXPECT_EQ(capture.views[1].distortion.k2, -0.02);
  EXPECT_EQ(capture.views[1].distortion.p2, 0.002);
  // Centre -Rᵀ t with R of a quarter turn about y: R = [[0,0,1],[0,1,0],[-1,0,0]].
  const Eigen::Vector3d centre = capture.views[1].camera.world_from_camera.position_m;
  EXPECT_NEAR(centre.x(), 1.3, 1e-9);
  EXPECT_NEAR(centre.y(), -0.2, 1e-9);
  EXPECT_NEAR(centre.z(), -0.1, 1e-9);
  // COLMAP looks along +z of the camera, which is row 2 of R in the world.
  const Eigen::Vector3d forward =
      capture.views[1].camera.world_from_camera.orientation * Eigen::Vector3d(0, 0, -1);
  EXPECT_NEAR((forward - Eigen::Vector3d(-1, 0, 0)).norm(), 0, 1e-9);
  const Eigen::Vector3d up = capture.views[1].camera.world_from_camera.orientation * Eigen::Vector3d(0, 1, 0);
  EXPECT_NEAR((up - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-9);
  ASSERT_EQ(capture.points.size(), 2u);
  EXPECT_EQ(capture.points[1].x(), 2.0f);
  EXPECT_NEAR(capture.point_colours[0].z(), 0.2f, 1e-6f);
}

void write_colmap_photos(const ScratchFolder& folder) {
  for (const char* name : {"images/0.png", "images/left/1.png", "images/left/2.png"})
    write_photo(folder / name);
}

std::string error_of(const std::filesystem::path& path) {
  const auto capture = read_capture(path);
  return capture ? "" : capture.error().message;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST(ReadCapture, TransformsWithAndWithoutEndings) {
  ScratchFolder folder;
  for (const char* name : {"images/a.png", "images/b.png", "images/c.png"}) write_photo(folder / name);
  folder.write(
      "transforms.json",
      transforms(
          frame("images/c") + "," + frame("./images/a.png") + "," +
              frame("images/b.png", ", \"fl_x\": 20, \"fl_y\": 21, \"k1\": 0.1, \"mask_path\": \"m.png\""),
          "\"w\": 8, \"h\": 6, \"fl_x\": 10, \"cx\": 4.25, \"ply_file_path\": \"missing.ply\""));
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture) << capture.error().message;
  ASSERT_EQ(capture->views.size(), 3u);
  const CapturedView& c = capture->views[2];
  EXPECT_EQ(c.name, "images/c");
  EXPECT_EQ(c.picture.filename(), "c.png");
  EXPECT_EQ(c.camera.focal_y_px, 10.0);
  EXPECT_EQ(c.camera.centre_x_px, 4.25);
  EXPECT_EQ(c.camera.centre_y_px, 3.0);
  EXPECT_NEAR((c.camera.world_from_camera.position_m - Eigen::Vector3d(0.5, -2, 1)).norm(), 0, 1e-12);
  // The camera looks along -z of its matrix: here +y.
  EXPECT_NEAR(
      (c.camera.world_from_camera.orientation * Eigen::Vector3d(0, 0, -1) - Eigen::Vector3d(0, 1, 0)).norm(),
      0, 1e-9);
  const CapturedView& b = capture->views[1];
  EXPECT_EQ(b.camera.focal_x_px, 20.0);
  EXPECT_EQ(b.camera.focal_y_px, 21.0);
  EXPECT_EQ(b.distortion.k1, 0.1);
  EXPECT_EQ(b.mask, folder / "m.png");
  ASSERT_EQ(capture->notes.size(), 1u);
  EXPECT_TRUE(contains(capture->notes[0], "missing.ply"));
  EXPECT_TRUE(capture->points.empty());
}

TEST(ReadCapture, SizesComeFromThePhotosIfTheyAreMissing) {
  ScratchFolder folder;
  std::string frames;
  for (const char* name : {"a", "b", "c"}) {
    write_photo(folder / (std::string(name) + ".png"), 20, 10);
    frames += (frames.empty() ? "" : ",") + frame(name);
  }
  folder.write("transforms.json", transforms(frames, "\"camera_angle_x\": 1.5707963267948966"));
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture) << capture.error().message;
  EXPECT_EQ(capture->views[0].camera.width, 20);
  EXPECT_EQ(capture->views[0].camera.height, 10);
  EXPECT_NEAR(capture->views[0].camera.focal_x_px, 10.0, 1e-9);
}

TEST(ReadCapture, EveryEighthViewIsHeldOutUnlessTheCaptureNamesThem) {
  ScratchFolder folder;
  std::string frames;
  for (int i = 0; i < 17; ++i) {
    const std::string name = format_text("%02d.png", i);
    write_photo(folder / name);
    frames += (i == 0 ? "" : ",") + frame(name);
  }
  folder.write("transforms.json", transforms(frames));
  auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  for (size_t i = 0; i < 17; ++i) EXPECT_EQ(capture->views[i].held_out, i == 7 || i == 15);
  folder.write("transforms_test.json", transforms(frame("03.png")));
  capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  for (size_t i = 0; i < 17; ++i) EXPECT_EQ(capture->views[i].held_out, i == 3);
}

TEST(ReadCapture, PointsOfAPlyFileWithoutNormals) {
  ScratchFolder folder;
  std::string frames;
  for (const char* name : {"a", "b", "c"}) {
    write_photo(folder / (std::string(name) + ".png"));
    frames += (frames.empty() ? "" : ",") + frame(name);
  }
  folder.write("transforms.json",
               transforms(frames, "\"w\": 8, \"h\": 6, \"fl_x\": 10, \"ply_file_path\": \"points.ply\""));
  folder.write(
      "points.ply",
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n1 2 3 255 0 102\nnan 1 1 0 "
      "0 0\n");
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture) << capture.error().message;
  ASSERT_EQ(capture->points.size(), 1u);
  EXPECT_EQ(capture->points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_NEAR(capture->point_colours[0].z(), 0.4f, 1e-6f);
}

TEST(ReadCapture, BinaryAndTextModelsOfColmapAgree) {
  ScratchFolder binary, text;
  write_colmap_photos(binary);
  write_colmap_photos(text);
  const BinaryModel model = binary_model();
  binary.write("sparse/0/cameras.bin", model.cameras);
  binary.write("sparse/0/images.bin", model.images);
  binary.write("sparse/0/points3D.bin", model.points);
  binary.write("sparse/0/rigs.bin", "newer versions write more files");
  const auto from_binary = read_capture(binary.path());
  ASSERT_TRUE(from_binary) << from_binary.error().message;
  expect_colmap_model(*from_binary);

  text.write("sparse/cameras.txt",
             "# cameras\n7 OPENCV 8 6 10 11 4 3 0.1 -0.02 0.001 0.002\r\n2 PINHOLE 8 6 12 13 4.5 3.5\n");
  // The first photo has an empty line of points, the second two points, the third no line at all.
  text.write("sparse/images.txt",
             "# images\n1 0.70710678118654757 0 0.70710678118654757 0 0.1 0.2 0.3 2 0.png\n\n"
             "2 0.70710678118654757 0 0.70710678118654757 0 0.1 0.2 1.3 7 left/1.png\n1.5 2.5 -1 3.5 4.5 12\n"
             "3 0.70710678118654757 0 0.70710678118654757 0 0.1 0.2 2.3 7 left/2.png\n");
  text.write("sparse/points3D.txt",
             "# points\n0 1 2 3 255 0 51 0.5\n1 2 2 3 255 0 51 0.5 1 1 2 1 3 1\n"
             "2 3 2 3 255 0 51 0.5 1 1 2 1\n");
  const auto from_text = read_capture(text.path());
  ASSERT_TRUE(from_text) << from_text.error().message;
  expect_colmap_model(*from_text);
}

TEST(ReadCapture, DamagedBinaryModelsAreRefused) {
  const BinaryModel model = binary_model();
  const auto bytes = [](const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
  };
  const auto cameras = decode_colmap_cameras(bytes(model.cameras), "cameras.bin");
  ASSERT_TRUE(cameras);
  ASSERT_TRUE(decode_colmap_images(bytes(model.images), *cameras, "images.bin"));
  ColmapModel read;
  ASSERT_TRUE(decode_colmap_points(bytes(model.points), "points3D.bin", read));
  for (size_t length = 0; length < model.cameras.size(); ++length)
    EXPECT_FALSE(decode_colmap_cameras(bytes(model.cameras.substr(0, length)), "cameras.bin")) << length;
  for (size_t length = 0; length < model.images.size(); ++length)
    EXPECT_FALSE(decode_colmap_images(bytes(model.images.substr(0, length)), *cameras, "images.bin"))
        << length;
  for (size_t length = 0; length < model.points.size(); ++length)
    EXPECT_FALSE(decode_colmap_points(bytes(model.points.substr(0, length)), "points3D.bin", read)) << length;
  // Any byte changed: an error or another model, never a crash or a large allocation.
  for (size_t at = 0; at < model.images.size(); ++at) {
    std::string changed = model.images;
    changed[at] = static_cast<char>(changed[at] ^ 0xff);
    (void)decode_colmap_images(bytes(changed), *cameras, "images.bin");
  }
  for (size_t at = 0; at < model.cameras.size(); ++at) {
    std::string changed = model.cameras;
    changed[at] = static_cast<char>(changed[at] ^ 0xff);
    (void)decode_colmap_cameras(bytes(changed), "cameras.bin");
  }
}

TEST(ReadCapture, PointsOfColmapNeedTheSamePoses) {
  ScratchFolder folder;
  write_colmap_photos(folder);
  const BinaryModel model = binary_model();
  folder.write("sparse/0/cameras.bin", model.cameras);
  folder.write("sparse/0/images.bin", model.images);
  folder.write("sparse/0/points3D.bin", model.points);
  // The poses of the model in the form of OpenGL: centres (0.3 + i, -0.2, -0.1), forward -x, up -y.
  std::string frames;
  const char* names[] = {"images/0.png", "images/left/1.png", "images/left/2.png"};
  for (int i = 0; i < 3; ++i) {
    frames += format_text(
        "%s{\"file_path\": \"%s\", \"transform_matrix\": "
        "[[0,0,1,%.1f],[0,-1,0,-0.2],[1,0,0,-0.1],[0,0,0,1]]}",
        i == 0 ? "" : ",", names[i], 0.3 + i);
  }
  folder.write("transforms.json", transforms(frames));
  const auto same = read_capture(folder.path());
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(same->points.size(), 2u);
  frames.replace(frames.find("-0.2"), 4, "-0.9");
  folder.write("transforms.json", transforms(frames));
  const auto other = read_capture(folder.path());
  ASSERT_TRUE(other);
  EXPECT_TRUE(other->points.empty());
  ASSERT_EQ(other->notes.size(), 1u);
  EXPECT_TRUE(contains(other->notes[0], "poses differ in 1 of 3"));
}

TEST(ReadCapture, RefusesWithOneLine) {
  ScratchFolder folder;
  EXPECT_TRUE(contains(error_of(folder / "nothing"), "no such file"));
  EXPECT_TRUE(contains(error_of(folder.path()), "has no poses"));
  folder.write("transforms.json", "{");
  EXPECT_TRUE(contains(error_of(folder.path()), "is not a JSON object"));
  folder.write("transforms.json", transforms(""));
  EXPECT_TRUE(contains(error_of(folder.path()), "has 0 photos"));
  folder.write("transforms.json", transforms(frame("a.png")));
  EXPECT_TRUE(contains(error_of(folder.path()), "none of the 1 photos exists"));
  write_photo(folder / "a.png");
  write_photo(folder / "b.png");
  folder.write("transforms.json", transforms(frame("a.png") + "," + frame("b.png")));
  EXPECT_TRUE(contains(error_of(folder.path()), "has 2 photos with poses, fewer than 3; take more photos"));
  const auto with_head = [&](const std::string& head) {
    folder.write("transforms.json", transforms(frame("a.png"), head));
    return error_of(folder.path());
  };
  EXPECT_TRUE(contains(with_head("\"w\": 8, \"h\": 6"), "neither fl_x nor camera_angle_x"));
  EXPECT_TRUE(contains(with_head("\"w\": 8, \"h\": 6, \"fl_x\": \"10\""), "fl_x must be a number"));
  EXPECT_TRUE(contains(with_head("\"w\": -8, \"h\": 6, \"fl_x\": 10"), "w and h must be numbers"));
  EXPECT_TRUE(contains(with_head("\"w\": 8, \"h\": 6, \"fl_x\": 10, \"camera_model\": \"OPENCV_FISHEYE\""),
                       "not supported"));
  EXPECT_TRUE(contains(with_head("\"w\": 8, \"h\": 6, \"fl_x\": 10, \"k3\": 0.1"), "k3 and k4"));
  folder.write("transforms.json",
               "{\"w\":8,\"h\":6,\"fl_x\":10,\"frames\":[{\"file_path\":\"a.png\",\"transform_matrix\":[[1,2]"
               ",[3]]}]}");
  EXPECT_TRUE(contains(error_of(folder.path()), "must be a matrix"));
  folder.write("transforms.json",
               "{\"w\":8,\"h\":6,\"fl_x\":10,\"frames\":[{\"file_path\":\"a.png\",\"transform_matrix\":"
               "[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]}]}");
  EXPECT_TRUE(contains(error_of(folder.path()), "is not a rotation"));
}

TEST(ReadCapture, CameraModelsThatAreNotPinholeAreRefusedWithARemedy) {
  ScratchFolder folder;
  folder.write("sparse/0/cameras.txt", "1 OPENCV_FISHEYE 8 6 10 10 4 3 0 0 0 0\n");
  folder.write("sparse/0/images.txt", "");
  EXPECT_TRUE(contains(error_of(folder.path()), "image_undistorter"));
  folder.write("sparse/0/cameras.txt", "1 PINHOLE 8 6 10\n");
  EXPECT_TRUE(contains(error_of(folder.path()), "cameras.txt: a camera is not"));
  folder.write("sparse/0/cameras.txt", "1 PINHOLE 8 6 10 10 4 3\n");
  folder.write("sparse/0/images.txt", "1 1 0 0 0 0 0 0 9 a.png\n");
  EXPECT_TRUE(contains(error_of(folder.path()), "camera 9, which does not exist"));
}

}  // namespace livegs
