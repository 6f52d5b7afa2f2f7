// SPDX-License-Identifier: Apache-2.0
// Writes a synthetic scene in the layouts of the browser client's worker, and its pictures by the CPU
// rasteriser:
//   scene.json   objects, pass constants and cameras; places and lengths of their arrays in scene.bin, in
//   words scene.bin    arrays of 32-bit words, little-endian view_N.png   the picture of camera N
// Usage: reference_picture DIRECTORY [KERNELS]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/assert.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/kernels/lattice_skinning.h"
#include "skin/kernels/skin_rigid_layout.h"
#include "skin/skin_kernels.h"
#include "splat/half_float.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr int kWidth_px = 480, kHeight_px = 360;
constexpr double kPi = 3.14159265358979;

using Random = std::mt19937;

float between(Random& random, double low, double high) {
  return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
}

// Kernels on the surface of a box around the origin, with bands of a moderate size. Some are needles or
// discs.
GaussianAsset box_of_kernels(Random& random, size_t count, const Eigen::Vector3f& half_m, int degree,
                             bool antialiased) {
  GaussianAsset asset;
  asset.sh_degree = degree;
  asset.antialiased = antialiased;
  asset.resize(count);
  const float size = 2.0f * half_m.maxCoeff() / std::sqrt(static_cast<float>(count) / 6);
  for (size_t i = 0; i < count; ++i) {
    Eigen::Vector3f at(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    const int axis = static_cast<int>(i % 3);
    at[axis] = at[axis] < 0 ? -1.0f : 1.0f;
    asset.positions[i] = at.cwiseProduct(half_m);
    for (int a = 0; a < 3; ++a) asset.log_scales[i][a] = std::log(size * between(random, 0.1, 0.8));
    if (i % 17 == 0) asset.log_scales[i][0] = std::log(1e-5f);
    if (i % 23 == 0) asset.log_scales[i][1] = std::log(3 * size);
    asset.rotations[i] =
        Eigen::Quaternionf(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1), 0.3f)
            .normalized();
    asset.opacity_logits[i] = between(random, -4, 5);
    for (int c = 0; c < 3; ++c) asset.sh_dc[i][c] = between(random, -1.5, 1.5);
  }
  // As halves, so that reference and page have the same values.
  for (Eigen::Vector3f& value : asset.sh_rest)
    for (int c = 0; c < 3; ++c) value[c] = float_of_half(half_of_float(between(random, -0.25, 0.25)));
  return asset;
}

// A lattice of n cells a side around the box.
RestBody lattice_around(const Eigen::Vector3f& half_m, int cells_x) {
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.cell_width_m = 2.0 * half_m.x() / cells_x;
  const auto cells = [&](int axis) {
    return std::max(1, static_cast<int>(std::ceil(2.0 * half_m[axis] / rest.cell_width_m - 0.2)));
  };
  const int nx = cells(0), ny = cells(1), nz = cells(2);
  rest.object_from_lattice.position_m = -0.5 * rest.cell_width_m * Eigen::Vector3d(nx, ny, nz);
  const auto node = [&](int x, int y, int z) {
    return static_cast<uint32_t>((z * (ny + 1) + y) * (nx + 1) + x);
  };
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) rest.node_coordinates.push_back({x, y, z});
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        auto& cell = rest.cells.emplace_back();
        for (int c = 0; c < 8; ++c) cell[c] = node(x + (c & 1), y + ((c >> 1) & 1), z + ((c >> 2) & 1));
      }
  return rest;
}

struct Object {
  uint32_t id = 0;
  bool environment = false;
  GaussianAsset asset;
  RestBody rest;
  ObjectDrivers drivers;
  KernelBindings bindings;
  PosedKernels posed;
};

std::vector<Object> make_objects(size_t count) {
  Random random(7);
  std::vector<Object> objects(4);
  Object& floor = objects[0];
  floor.id = 1;
  floor.environment = true;
  floor.asset = box_of_kernels(random, count / 4, {1.5f, 0.02f, 1.5f}, 0, false);
  floor.rest.bodies = {Pose{}};
  floor.drivers.poses = {Pose{{0, -0.05, 0}, Eigen::Quaterniond::Identity()}};

  Object& broken = objects[1];
  broken.id = 12;
  broken.asset = box_of_kernels(random, count / 4, {0.2f, 0.2f, 0.2f}, 3, false);
  for (int body = 0; body < 8; ++body) {
    const Eigen::Vector3d origin(body & 1 ? 0.1 : -0.1, body & 2 ? 0.1 : -0.1, body & 4 ? 0.1 : -0.1);
    broken.rest.bodies.push_back(
        {origin, Eigen::Quaterniond(Eigen::AngleAxisd(0.2 * body, Eigen::Vector3d::UnitX()))});
    broken.drivers.poses.push_back(
        {Eigen::Vector3d(-0.6, 0.3, 0) + 1.3 * origin,
         Eigen::Quaterniond(Eigen::AngleAxisd(0.7 * body, Eigen::Vector3d(1, 2, 0.5).normalized()))});
  }

  Object& soft = objects[2];
  soft.id = 40;
  const Eigen::Vector3f half_m(0.2f, 0.3f, 0.2f);
  soft.asset = box_of_kernels(random, count / 4, half_m, 2, false);
  for (size_t i = 0; i < soft.asset.size(); i += 31)
    soft.asset.positions[i] *= 1.6f;  // haze outside of the cells
  soft.rest = lattice_around(half_m, 5);
  soft.rest.object_from_asset.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  for (size_t n = 0; n < soft.rest.node_coordinates.size(); ++n) {
    Eigen::Vector3d x =
        soft.rest.object_from_lattice *
        Eigen::Vector3d(soft.rest.cell_width_m * soft.rest.node_coordinates[n].cast<double>());
    const double bend = 1.5 * x.y();
    x = Eigen::AngleAxisd(bend, Eigen::Vector3d::UnitY()) * x;
    x.y() *= 1.0 - 0.9 * std::max(0.0, x.x());  // crushed on one side
    x.z() *= x.y() > 0.15 ? -0.4 : 1.2;         // inverted on top
    x.x() += 0.3 * x.y() * x.y();
    soft.drivers.positions_m.push_back((x + Eigen::Vector3d(0.1, 0.35, 0.1)).cast<float>());
  }

  Object& mip = objects[3];
  mip.id = 41;
  mip.asset = box_of_kernels(random, count / 4, {0.15f, 0.15f, 0.15f}, 1, true);
  mip.rest.bodies = {Pose{}};
  mip.drivers.poses = {Pose{
      {0.7, 0.25, -0.2}, Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d(0, 1, 1).normalized()))}};

  for (Object& object : objects) {
    object.drivers.object_id = object.id;
    object.drivers.kind = object.rest.kind;
    auto bound = bind_kernels(object.asset, object.rest);
    LIVEGS_ASSERT(bound);
    object.bindings = *std::move(bound);
    skin_kernels(object.asset, object.rest, object.bindings, object.drivers, object.posed);
  }
  return objects;
}

std::vector<Camera> make_cameras() {
  const auto at = [](double x, double y, double z, double tx, double ty, double tz) {
    return look_at({x, y, z}, {tx, ty, tz}, Eigen::Vector3d::UnitY(), 0.7, kWidth_px, kHeight_px);
  };
  std::vector<Camera> cameras{at(0, 1.1, 2.6, 0, 0.25, 0),        at(2.0, 0.6, -1.5, 0, 0.25, 0),
                              at(-2.2, 1.6, -0.4, 0, 0.2, 0),     at(0.3, 0.5, 0.8, 0.1, 0.35, 0.1),
                              at(-0.62, 0.32, 0.3, -0.6, 0.3, 0), at(0.1, 0.35, 0.1, -1, 0.3, 0.2)};
  // Two eyes of a headset: asymmetric frusta, 63 mm apart.
  for (const double side : {-1.0, 1.0}) {
    Pose pose = cameras[0].world_from_camera;
    pose.position_m += pose.orientation * Eigen::Vector3d(0.0315 * side, 0, 0);
    cameras.push_back(camera_from_fov(pose, side < 0 ? -0.8 : -0.6, side < 0 ? 0.6 : 0.8, 0.7, -0.75,
                                      kWidth_px, kHeight_px));
  }
  return cameras;
}

// Arrays of 32-bit words, one after the other.
class Words {
 public:
  template <typename T>
  std::string add(const T* from, size_t count) {
    static_assert(sizeof(T) % 4 == 0);
    const size_t first = words_.size(), added = count * sizeof(T) / 4;
    words_.resize(first + added);
    if (added > 0) std::memcpy(&words_[first], from, 4 * added);
    return "[" + std::to_string(first) + "," + std::to_string(added) + "]";
  }
  const std::vector<uint32_t>& all() const { return words_; }

 private:
  std::vector<uint32_t> words_;
};

std::string list(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    char number[32];
    std::snprintf(number, sizeof number, "%.17g", value);
    text += (text.empty() ? "[" : ",") + std::string(number);
  }
  return text + "]";
}

// The message 'kernels' of an object, and its rows of drivers (as device_skin.cpp and device_kernels.cpp).
std::string describe(const Object& object, size_t base, Words& words) {
  const GaussianAsset& asset = object.asset;
  std::vector<RestKernelRow> rest(asset.size());
  std::vector<KernelLookRow> looks(asset.size());
  const size_t row_words = (3 * asset.sh_rest_count() + 1) / 2;
  std::vector<uint32_t> bands(asset.size() * row_words, 0);
  Eigen::AlignedBox3f box;
  for (size_t i = 0; i < asset.size(); ++i) {
    const KernelBinding& b = object.bindings.kernels[i];
    const Symmetric3f& s = object.bindings.rest_covariances_m2[i];
    rest[i] = {b.drivers[0], b.weights[0], b.weights[1], b.weights[2], s[0], s[1], s[2], s[3], s[4], s[5]};
    if (object.rest.kind == DriverKind::Rigid) {
      const Eigen::Vector3f& x = object.bindings.rest_positions_m[i];
      rest[i].at_x = x.x(), rest[i].at_y = x.y(), rest[i].at_z = x.z();
    }
    const auto log2_opacity =
        static_cast<float>(-std::log1p(std::exp(-double{asset.opacity_logits[i]})) * M_LOG2E);
    looks[i] = {log2_opacity, asset.sh_dc[i].x(), asset.sh_dc[i].y(), asset.sh_dc[i].z()};
    for (size_t c = 0; c < 3 * asset.sh_rest_count(); ++c) {
      const float value = asset.sh_rest[i * asset.sh_rest_count() + c / 3][static_cast<int>(c % 3)];
      bands[i * row_words + c / 2] |= static_cast<uint32_t>(half_of_float(value)) << (16 * (c % 2));
    }
    box.extend(object.posed.positions_m[i]);
  }
  std::string text =
      "{\"id\":" + std::to_string(object.id) + ",\"environment\":" + (object.environment ? "true" : "false") +
      ",\"base\":" + std::to_string(base) + ",\"count\":" + std::to_string(asset.size()) +
      ",\"sh_degree\":" + std::to_string(asset.sh_degree) +
      ",\"antialiased\":" + (asset.antialiased ? "true" : "false") +
      ",\"rest\":" + words.add(rest.data(), rest.size()) +
      ",\"looks\":" + words.add(looks.data(), looks.size()) +
      ",\"bands\":" + words.add(bands.data(), bands.size()) + ",\"bounds_m\":" +
      list({box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()});
  if (object.rest.kind == DriverKind::Lattice) {
    const std::vector<NodeState> states = node_states(object.bindings, object.drivers.positions_m);
    const LatticeBody body = lattice_body_of(object.rest, states);
    const Eigen::Matrix3f& f = body.gradient;
    const Eigen::Quaternionf& q = body.lattice_from_asset;
    text += ",\"cells\":" + words.add(object.rest.cells.data(), object.rest.cells.size()) +
            ",\"rows\":" + words.add(states.data(), states.size()) +
            ",\"lattice\":{\"cell_width_m\":" + list({body.cell_width_m}).substr(1);
    text.back() = ',';
    text += "\"cell_count\":" + std::to_string(object.rest.cells.size()) +
            ",\"node_count\":" + std::to_string(states.size()) +
            ",\"lattice_from_asset\":" + list({q.x(), q.y(), q.z(), q.w()}) + ",\"body_gradient\":" +
            list({f(0, 0), f(0, 1), f(0, 2), f(1, 0), f(1, 1), f(1, 2), f(2, 0), f(2, 1), f(2, 2)}) + "}";
  } else {
    std::vector<RigidPoseRow> rows;
    for (const TurnedBody& body : turned_bodies(object.rest, object.drivers)) {
      const Eigen::Matrix3f& r = body.world_from_body;
      const Eigen::Vector3f& x = body.position_m;
      const Eigen::Quaternionf& q = body.world_from_asset;
      rows.push_back({r(0, 0), r(0, 1), r(0, 2), x.x(), r(1, 0), r(1, 1), r(1, 2), x.y(), r(2, 0), r(2, 1),
                      r(2, 2), x.z(), q.x(), q.y(), q.z(), q.w()});
    }
    text += ",\"cells\":null,\"lattice\":null,\"rows\":" + words.add(rows.data(), rows.size());
  }
  return text + "}";
}

// Kernels by distance or by depth from a camera, nearest first, by their global index.
std::vector<uint32_t> order_of(const std::vector<Object>& objects, const Camera& camera) {
  std::vector<float> depths;
  const Eigen::Vector3d forward = camera.world_from_camera.orientation * -Eigen::Vector3d::UnitZ();
  for (const Object& object : objects)
    for (size_t i = 0; i < object.posed.positions_m.size(); ++i) {
      double depth =
          forward.dot(object.posed.positions_m[i].cast<double>() - camera.world_from_camera.position_m);
      if (object.environment) {
        const Symmetric3f& s = object.posed.covariances_m2[i];
        Eigen::Matrix3d m;
        m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
        depth += kEnvironmentOrderBias * std::sqrt(std::max(0.0, forward.dot(m * forward)));
      }
      depths.push_back(static_cast<float>(depth));
    }
  std::vector<uint32_t> order(depths.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return depths[a] < depths[b]; });
  return order;
}

int run(const std::string& directory, size_t count) {
  const std::vector<Object> objects = make_objects(count);
  Words words;
  std::string text = "{\"objects\":[";
  size_t base = 0;
  RasteriseOptions options;
  options.background = {0.08f, 0.08f, 0.1f};
  options.image_only = true;
  options.max_radius_px = 2.0f * kWidth_px;
  std::vector<DrawnObject> drawn;
  for (const Object& object : objects) {
    text += (base > 0 ? ",\n" : "\n") + describe(object, base, words);
    base += object.asset.size();
    drawn.push_back({&object.asset, &object.posed, object.id});
    if (object.environment) options.environments.push_back(object.id);
  }
  text += "],\n\"views\":[";
  Rasteriser rasteriser;
  RasterisedView view;
  int index = 0;
  for (const Camera& camera : make_cameras()) {
    rasteriser.draw(drawn, camera, options, view);
    const auto written = write_png(directory + "/view_" + std::to_string(index) + ".png", view.image);
    if (!written) {
      std::fprintf(stderr, "%s\n", written.error().message.c_str());
      return 1;
    }
    const std::vector<uint32_t> order = order_of(objects, camera);
    const Eigen::Vector3d& p = camera.world_from_camera.position_m;
    const Eigen::Quaterniond& q = camera.world_from_camera.orientation;
    text += (index++ > 0 ? ",\n" : "\n");
    text += "{\"position\":" + list({p.x(), p.y(), p.z()}) +
            ",\"orientation\":" + list({q.w(), q.x(), q.y(), q.z()}) +
            ",\"focal\":" + list({camera.focal_x_px, camera.focal_y_px}) +
            ",\"centre\":" + list({camera.centre_x_px, camera.centre_y_px}) +
            ",\"size\":" + list({double(camera.width), double(camera.height)}) +
            ",\"near_m\":" + list({camera.near_m}) + ",\"order\":" + words.add(order.data(), order.size()) +
            ",\"rgb\":";
    const std::vector<uint8_t> rgb = rgb_bytes(view.image);
    std::vector<uint32_t> packed(static_cast<size_t>(camera.width) * camera.height);
    for (size_t i = 0; i < packed.size(); ++i)
      packed[i] = rgb[3 * i] | rgb[3 * i + 1] << 8 | rgb[3 * i + 2] << 16 | 0xff000000u;
    text += words.add(packed.data(), packed.size()) + "}";
  }
  text += "]}\n";
  std::ofstream(directory + "/scene.json") << text;
  std::ofstream(directory + "/scene.bin", std::ios::binary)
      .write(reinterpret_cast<const char*>(words.all().data()),
             static_cast<std::streamsize>(4 * words.all().size()));
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: reference_picture DIRECTORY [KERNELS]\n");
    return 2;
  }
  return livegs::run(argv[1], argc > 2 ? std::stoul(argv[2]) : 6000);
}
