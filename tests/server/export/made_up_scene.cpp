// SPDX-License-Identifier: Apache-2.0
#include "server/export/made_up_scene.h"

#include <cmath>
#include <random>

#include "common/gaussian/synthetic_asset.h"

namespace livegs {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Kind = PortableShape::Kind;

class Maker {
 public:
  explicit Maker(uint64_t seed) : random_(seed), seed_(seed) {}

  PortableScene make() {
    PortableScene scene;
    scene.name = "made up \"" + std::to_string(seed_) + "\"";
    scene.gravity_m_s2 = point(10);
    scene.rate_hz = 60 + std::floor(number(0, 60));
    const size_t count = 4 + static_cast<size_t>(number(0, 5));
    for (size_t i = 0; i < count; ++i) scene.bodies.push_back(body(i));
    for (int i = 0; i < 3; ++i) scene.fixed.push_back(shape(static_cast<size_t>(i)));
    for (size_t i = 1; i < count; ++i) {
      if (scene.bodies[i].behavior != v1::Physics::RIGID) continue;
      PortableJoint joint;
      joint.hinge = number(0, 1) < 0.5;
      joint.body = i;
      if (number(0, 1) < 0.6) joint.other = 0;
      joint.point_m = point(0.5);
      if (joint.hinge) joint.axis = turn() * Vector3d::UnitX();
      scene.joints.push_back(joint);
    }
    PortableBody background;
    background.name = "background";
    background.drawn_only = true;
    background.world_from_object = pose();
    background.asset = std::make_shared<const GaussianAsset>(synthetic_asset(7, 0, seed_ + 99));
    background.kernel_count = 7;
    scene.bodies.push_back(background);
    scene.animation = animation(scene);
    return scene;
  }

 private:
  double number(double low, double high) {
    // The same on every machine, unlike std::uniform_real_distribution.
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  Vector3d point(double reach) {
    const double x = number(-reach, reach), y = number(-reach, reach), z = number(-reach, reach);
    return {x, y, z};
  }
  Quaterniond turn() {
    const double w = number(-1, 1), x = number(-1, 1), y = number(-1, 1), z = number(-1, 1);
    return Quaterniond(w, x, y, z + 1.5).normalized();
  }
  Pose pose() {
    const Vector3d position = point(3);
    return {position, turn()};
  }

  PortableShape shape(size_t kind) {
    PortableShape result;
    result.kind = static_cast<Kind>(kind % 6);
    result.owner_from_shape = pose();
    result.friction = number(0, 2);
    result.restitution = number(0, 1);
    if (result.kind == Kind::Box) result.size_m = point(0.4).cwiseAbs() + Vector3d::Constant(0.01);
    if (result.kind == Kind::Sphere || result.kind == Kind::Cylinder || result.kind == Kind::Capsule)
      result.radius_m = number(0.01, 1);
    if (result.kind == Kind::Cylinder || result.kind == Kind::Capsule) result.height_m = number(0.01, 1);
    if (result.kind == Kind::Mesh) {
      TriangleMesh mesh;
      for (int i = 0; i < 4; ++i) mesh.vertices_m.push_back(point(0.5));
      mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
      result.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
      result.convex = number(0, 1) < 0.5;
    }
    return result;
  }

  v1::EstimatedValue estimate(double scale) {
    v1::EstimatedValue value;
    value.set_low(scale * number(0.1, 0.5));
    value.set_best(scale * number(0.5, 1));
    value.set_high(scale * number(1, 3));
    value.set_source(v1::EstimatedValue::MODEL);
    value.set_reason("as \"seen\"\nin the picture: \xc3\xa4");
    return value;
  }

  PortableElastic elastic() {
    PortableElastic result;
    result.youngs_modulus_pa = std::pow(10, number(3, 8));
    result.poisson_ratio = number(0, 0.49);
    result.structure_coefficient = number(0.1, 1);
    result.plasticity = number(0, 1);
    result.damping = number(0, 2);
    result.accuracy.set_cell_width_m(number(0.01, 0.1));
    result.accuracy.set_substeps(4);
    result.accuracy.set_band(v1::ElasticAccuracy::BAND);
    v1::Region& region = result.regions.emplace_back();
    region.set_name("foot");
    region.set_fixed(true);
    for (int i = 0; i < 3; ++i) region.mutable_box()->add_min_m(number(-1, 0));
    RestBody& lattice = result.lattice;
    lattice.kind = DriverKind::Lattice;
    lattice.object_from_lattice = pose();
    lattice.cell_width_m = number(0.01, 0.1);
    for (int i = 0; i < 12; ++i) lattice.node_coordinates.emplace_back(i / 4 - 1, i / 2 % 2, i % 2);
    lattice.cells = {{0, 4, 2, 6, 1, 5, 3, 7}, {4, 8, 6, 10, 5, 9, 7, 11}};
    lattice.cell_fills = {0xfedcba9876543210, 1};
    return result;
  }

  PortableBody body(size_t index) {
    static constexpr const char* kNames[] = {"cup",  "cup 2", "a \"quoted\" name", "\xc3\xa4\xe2\x98\x95",
                                             "1/2",  "World", "Materials",         "line\nbreak",
                                             "cup_2"};
    PortableBody result;
    result.name = kNames[index % 9];
    static constexpr v1::Physics::Behavior kBehaviors[] = {v1::Physics::STATIC, v1::Physics::RIGID,
                                                           v1::Physics::ELASTIC, v1::Physics::RIGID};
    result.behavior = kBehaviors[index % 4];
    result.hidden = index % 5 == 3;
    result.world_from_object = pose();
    result.shapes.push_back(shape(index + static_cast<size_t>(seed_)));
    result.friction = result.shapes[0].friction;
    result.restitution = result.shapes[0].restitution;
    if (result.behavior != v1::Physics::STATIC) {
      result.velocity_m_s = point(5);
      result.angular_velocity_rad_s = point(20);
      result.mass_kg = std::pow(10, number(-3, 3));
      result.centre_m = point(0.3);
      result.inertia_kg_m2 = result.mass_kg * (point(0.1).cwiseAbs() + Vector3d::Constant(1e-4));
      result.object_from_inertia = turn();
    }
    if (result.behavior == v1::Physics::ELASTIC) result.elastic = elastic();
    v1::PhysicalParameters& estimates = result.estimates;
    estimates.set_label("mug");
    estimates.set_material("stoneware");
    estimates.set_confidence(number(0, 1));
    estimates.set_behavior(result.behavior);
    estimates.set_fill(v1::Physics::SHELL);
    estimates.set_fragile(index % 2 == 0);
    estimates.set_fracture_pieces(16);
    *estimates.mutable_mass_kg() = estimate(result.mass_kg + 0.1);
    *estimates.mutable_youngs_modulus_pa() = estimate(1e9);
    v1::MaterialPart& part = *estimates.add_parts();
    part.set_name("handle");
    part.set_mass_share(number(0, 1));
    estimates.add_interior_rgb(number(0, 1));
    GaussianAsset asset = synthetic_asset(5 + index, static_cast<int>(index % 4), seed_ * 100 + index);
    asset.antialiased = (index + seed_) % 3 == 0;
    result.asset = std::make_shared<const GaussianAsset>(std::move(asset));
    result.kernel_count = result.asset->size();
    result.object_from_asset = {number(0.1, 2), turn(), point(0.2)};
    return result;
  }

  PortableAnimation animation(const PortableScene& scene) {
    PortableAnimation result;
    for (int i = 0; i < 6; ++i) result.times_s.push_back(i / scene.rate_hz);
    for (size_t i = 0; i + 1 < scene.bodies.size(); ++i) {
      PortableTrack track;
      track.body = i;
      track.first_key = i % 3;
      const size_t size = i == 1 ? 0 : 6 - track.first_key - i % 2;
      if (size == 0) track.first_key = 0;
      for (size_t key = 0; key < size; ++key) {
        track.world_from_object.push_back(pose());
        if (!scene.bodies[i].elastic) continue;
        auto& nodes = track.nodes_m.emplace_back();
        for (int n = 0; n < 12; ++n) nodes.push_back(point(2).cast<float>());
      }
      result.tracks.push_back(std::move(track));
    }
    return result;
  }

  std::mt19937_64 random_;
  uint64_t seed_;
};

}  // namespace

PortableScene made_up_scene(uint64_t seed) { return Maker(seed).make(); }

}  // namespace livegs
