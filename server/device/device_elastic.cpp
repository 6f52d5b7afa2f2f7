// SPDX-License-Identifier: GPL-3.0-or-later
#include "device/device_elastic.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <set>
#include <vector>

#include "compute/buffer.h"
#include "core/log.h"
#include "device/passes/elastic_passes.h"

namespace livegs {
namespace {

using namespace shader;

static_assert(sizeof(FlatNode) == sizeof(NodeStateRow) && sizeof(FlatVector) == sizeof(vec4));
static_assert(FlatLattice::Constants().size() == kCellConstants && FlatLattice::Gains().size() == kCellGains);

vec4 row_of(const Eigen::Vector3d& v, double w = 0.0) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}
// Part of a double below the precision of a float. GCC 12 would vectorise the two conversions away.
float rest_of(double value) {
  volatile const float high = static_cast<float>(value);
  return static_cast<float>(value - static_cast<double>(high));
}
vec4 low_row_of(const Eigen::Vector3d& v) { return {rest_of(v.x()), rest_of(v.y()), rest_of(v.z()), 0.0f}; }
vec4 row_of(const FlatVector& v) { return {v[0], v[1], v[2], v[3]}; }
Eigen::Vector3d vector_of(const vec4& v) { return {v.x, v.y, v.z}; }
void set_columns(const Eigen::Matrix3d& m, vec4& x, vec4& y, vec4& z) {
  x = row_of(m.col(0));
  y = row_of(m.col(1));
  z = row_of(m.col(2));
}

constexpr const char* kCheaper = "the CPU is predicted to be cheaper";

struct Member {
  FlatBody* body = nullptr;
  uint64_t revision = 0;
  FlatLattice lattice;
  uint32_t first_node = 0, first_surface = 0, first_point = 0;
  std::vector<uint32_t> cell_rows;  // by cell: its row on the device
  FlatState state;                  // of this tick
};

BodyRow body_row(const FlatState& state, const FlatTick& tick) {
  const MomentumLedger& ledger = state.ledger;
  BodyRow row;
  std::memset(static_cast<void*>(&row), 0, sizeof row);
  row.gravity = row_of(tick.gravity_m_s2);
  row.load_n = row_of(state.load_n);
  const Eigen::Vector3d push = state.step_s * (state.mass_kg * tick.gravity_m_s2 + state.load_n);
  row.push_n_s = row_of(push);
  row.push_low = low_row_of(push);
  set_columns(ledger.map, row.map_x, row.map_y, row.map_z);
  row.mass_kg = static_cast<float>(state.mass_kg);
  row.step_s = static_cast<float>(state.step_s);
  row.damping_per_s = static_cast<float>(state.damping_per_s);
  row.weight_n = static_cast<float>(state.weight_n);
  row.moving_part = static_cast<float>(state.moving_part);
  row.friction = static_cast<float>(state.friction);
  row.inverse_four_widths = static_cast<float>(state.inverse_four_widths);
  row.slow_m_s = static_cast<float>(state.slow_m_s);
  row.loss_factor = static_cast<float>(state.loss_factor);
  row.stiffness_pa = static_cast<float>(state.stiffness_pa);
  row.steps = static_cast<uint>(state.steps);
  row.flags = (state.held ? kBodyHeld : 0) | (state.may_be_second_order ? kBodySecondOrder : 0);
  row.gains = state.impact ? 1 : 0;
  row.first = state.first;
  row.uneven = state.uneven;
  row.strained = state.strained;
  row.touching = state.touching;
  row.backward = state.backward;
  row.deviation_m_s = static_cast<float>(state.deviation_m_s);
  row.pressed_n = static_cast<float>(state.pressed_n);
  row.carried_n = static_cast<float>(state.carried_n);
  const Eigen::Vector4f q = ledger.step_orientation.coeffs().cast<float>();
  row.orientation = {q.x(), q.y(), q.z(), q.w()};
  row.momentum = row_of(ledger.motion.momentum);
  row.momentum_low = low_row_of(ledger.motion.momentum);
  row.angular = row_of(ledger.motion.angular_momentum);
  row.angular_low = low_row_of(ledger.motion.angular_momentum);
  row.momentum_before = row_of(ledger.momentum_before);
  row.angular_before = row_of(ledger.angular_before);
  row.velocity_correction = row_of(ledger.velocity_correction);
  row.spin_correction = row_of(ledger.spin_correction);
  row.contact_lag_m = row_of(ledger.contact_lag_m);
  row.between_n_s = row_of(ledger.between_steps_impulse);
  row.centre = row_of(ledger.motion.centre_m);
  row.load_torque = row_of(state.load_torque);
  set_columns(ledger.motion.inertia, row.inertia_x, row.inertia_y, row.inertia_z);
  set_columns(ledger.node_inertia, row.nodes_x, row.nodes_y, row.nodes_z);
  return row;
}

// The body's part of the state after the steps.
void read_body(const BodyRow& row, FlatState& state) {
  MomentumLedger& ledger = state.ledger;
  state.first = row.first != 0;
  state.strained = row.strained != 0;
  state.touching = row.touching != 0;
  state.backward = row.backward != 0;
  state.slow = row.slow != 0;
  state.second_order = row.second_order != 0;
  state.ever_strained = row.ever_strained != 0;
  state.deviation_m_s = row.deviation_m_s;
  state.pressed_n = row.pressed_n;
  state.carried_n = row.carried_n;
  ledger.step_orientation =
      Eigen::Quaterniond(row.orientation.w, row.orientation.x, row.orientation.y, row.orientation.z);
  ledger.motion.momentum = vector_of(row.momentum) + vector_of(row.momentum_low);
  ledger.motion.angular_momentum = vector_of(row.angular) + vector_of(row.angular_low);
  ledger.momentum_before = vector_of(row.momentum_before);
  ledger.angular_before = vector_of(row.angular_before);
  ledger.contact_lag_m = vector_of(row.contact_lag_m);
  state.strain_squared = uintBitsToFloat(row.strain_bits);
  state.bent_squared = uintBitsToFloat(row.bent_bits);
  state.contact_n_s = row.contact_n_s;
  state.contact_moment = vector_of(row.contact_moment);
}

ColliderRow collider_row(const FlatCollider& collider) {
  ColliderRow row;
  row.at = row_of(collider.at_m, collider.friction);
  set_columns(collider.world_from_collider, row.axis_x, row.axis_y, row.axis_z);
  row.axis_x.w = static_cast<float>(collider.kind == FlatCollider::Kind::Plane ? kPlane
                                    : collider.kind == FlatCollider::Kind::Box ? kBox
                                                                               : kSphere);
  row.size = row_of(collider.half_m, collider.thickness_m);
  return row;
}

}  // namespace

// The bodies on the device and their buffers.
struct DeviceElastic::Fleet {
  Fleet(Backend& of_passes, std::optional<ElasticCost> of_both) : backend(of_passes), cost(of_both) {}

  Result<void> step(std::span<DeviceBody> bodies, const FlatTick& tick);
  void report(std::span<const DeviceBody> bodies);
  Result<void> upload_lattices();
  Result<void> run_steps(uint32_t steps, bool touches, bool backward);

  template <class Row>
  Result<void> fill(Buffer& buffer, const std::vector<Row>& rows, const char* what) {
    if (auto made = reserve(buffer, rows.size() * sizeof(Row), what); !made) return made;
    if (rows.empty()) return {};
    return backend.upload(buffer.id(), std::as_bytes(std::span(rows)));
  }
  Result<void> reserve(Buffer& buffer, size_t bytes, const char* what) {
    return buffer.reserve(backend, std::max<size_t>(bytes, 16), what);
  }
  template <class Row>
  Result<void> read(const Buffer& buffer, std::vector<Row>& rows) {
    if (rows.empty()) return {};
    return backend.read(buffer.id(), std::as_writable_bytes(std::span(rows)));
  }
  Result<void> dispatch(const Pass& pass, std::initializer_list<BufferId> ids,
                        const ElasticConstants& constants) {
    ++counts.dispatches;
    return backend.dispatch(pass, std::span(ids.begin(), ids.size()), std::as_bytes(std::span(&constants, 1)),
                            constants.count);
  }

  Backend& backend;
  std::optional<ElasticCost> cost;
  std::set<std::string> reported;  // reasons that were logged
  std::mutex one_call;             // guards everything below
  Counts counts;
  std::string failure;

  std::vector<Member> members;
  std::vector<uint32_t> cell_begins, surface_begins;  // by rank of colour, and the end
  uint32_t node_rows = 0, row_count = 0;
  bool loaded = false;  // some node has a load on the device
  std::vector<uint> block_bodies;
  Buffer bodies_, now_, before_, solve_, drift_, loads_, block_bodies_, cells_, rotations_, constants_,
      gains_, surface_cells_, points_, contacts_, colliders_, blocks_;
};

// Concatenates the lattices: nodes and sums by body, cells and surface cells by colour.
Result<void> DeviceElastic::Fleet::upload_lattices() {
  ++counts.lattice_uploads;
  std::vector<uint32_t> colours;
  for (const Member& member : members) {
    for (const FlatLattice::Cell& cell : member.lattice.cells) colours.push_back(cell.colour);
    for (const FlatLattice::SurfaceCell& cell : member.lattice.surface_cells) colours.push_back(cell.colour);
    std::sort(colours.begin(), colours.end());
    colours.erase(std::unique(colours.begin(), colours.end()), colours.end());
  }
  const auto rank_count = static_cast<uint32_t>(colours.size());
  const auto rank_of = [&](uint32_t colour) {
    return static_cast<uint32_t>(std::lower_bound(colours.begin(), colours.end(), colour) - colours.begin());
  };
  cell_begins.assign(rank_count + 1, 0);
  surface_begins.assign(rank_count + 1, 0);
  node_rows = row_count = 0;
  block_bodies.clear();
  std::vector<SurfacePointRow> point_rows;
  uint32_t surface_count = 0;
  std::vector<uint32_t> first_rows;  // of constants, by member
  for (uint32_t m = 0; m < members.size(); ++m) {
    Member& member = members[m];
    const FlatLattice& lattice = member.lattice;
    member.first_node = node_rows;
    member.first_surface = surface_count;
    member.first_point = static_cast<uint32_t>(point_rows.size());
    const auto blocks = static_cast<uint32_t>((lattice.node_count + kElasticBlock - 1) / kElasticBlock);
    block_bodies.insert(block_bodies.end(), blocks, m);
    node_rows += blocks * kElasticBlock;
    surface_count += static_cast<uint32_t>(lattice.surface_cells.size());
    first_rows.push_back(row_count);
    row_count += static_cast<uint32_t>(lattice.constants.size());
    for (const FlatLattice::Cell& cell : lattice.cells) ++cell_begins[rank_of(cell.colour) + 1];
    for (const FlatLattice::SurfaceCell& cell : lattice.surface_cells)
      ++surface_begins[rank_of(cell.colour) + 1];
    for (const FlatLattice::SurfacePoint& point : lattice.surface_points) {
      const float* w = point.weights;
      point_rows.push_back({{w[0], w[1], w[2], w[3]}, {w[4], w[5], w[6], w[7]}, {point.mobility, 0, 0, 0}});
    }
  }
  for (uint32_t r = 0; r < rank_count; ++r) {
    cell_begins[r + 1] += cell_begins[r];
    surface_begins[r + 1] += surface_begins[r];
  }
  std::vector<CellRow> cells(cell_begins.back());
  std::vector<SurfaceCellRow> surface_cells(surface_begins.back());
  std::vector<std::array<float, kCellConstants>> constants;
  std::array<std::vector<std::array<float, kCellGains>>, 4> gains;
  std::vector<uint32_t> next_cell = cell_begins, next_surface = surface_begins;
  for (uint32_t m = 0; m < members.size(); ++m) {
    Member& member = members[m];
    const FlatLattice& lattice = member.lattice;
    member.cell_rows.clear();
    for (const FlatLattice::Cell& cell : lattice.cells) {
      const uint32_t rank = rank_of(cell.colour), row = next_cell[rank]++;
      member.cell_rows.push_back(row);
      for (int c = 0; c < 8; ++c) cells[row].nodes[c] = member.first_node + cell.nodes[c];
      cells[row].body = m;
      cells[row].constants = first_rows[m] + cell.constants;
      cells[row].rank = rank;
      cells[row].spare = 0;
    }
    uint32_t sums = member.first_surface;
    for (const FlatLattice::SurfaceCell& cell : lattice.surface_cells) {
      const uint32_t rank = rank_of(cell.colour);
      SurfaceCellRow& row = surface_cells[next_surface[rank]++];
      row = {};
      for (int c = 0; c < 8; ++c) row.nodes[c] = member.first_node + cell.nodes[c];
      row.body = m;
      row.begin = member.first_point + cell.begin;
      row.end = member.first_point + cell.end;
      row.rank = rank;
      row.sums = sums++;
    }
    constants.insert(constants.end(), lattice.constants.begin(), lattice.constants.end());
    for (size_t v = 0; v < 4; ++v) {
      gains[v].insert(gains[v].end(), lattice.gains[v].begin(), lattice.gains[v].end());
      gains[v].resize(constants.size());  // without impact steps
    }
  }
  for (size_t v = 1; v < 4; ++v) gains[0].insert(gains[0].end(), gains[v].begin(), gains[v].end());
  loaded = false;
  const size_t states = node_rows * sizeof(NodeStateRow);
  Result<void> done;
  if (!(done = reserve(bodies_, members.size() * sizeof(BodyRow), "elastic bodies")) ||
      !(done = reserve(now_, states, "elastic nodes")) ||
      !(done = reserve(before_, states, "previous elastic nodes")) ||
      !(done = reserve(solve_, node_rows * sizeof(NodeSolveRow), "predicted elastic nodes")) ||
      !(done = reserve(drift_, node_rows * sizeof(NodeDriftRow), "elastic velocities")) ||
      !(done = fill(loads_, std::vector<vec4>(node_rows), "elastic loads")) ||
      !(done = fill(block_bodies_, block_bodies, "blocks of elastic nodes")) ||
      !(done = fill(cells_, cells, "elastic cells")) ||
      !(done = reserve(rotations_, cells.size() * sizeof(vec4), "rotations of elastic cells")) ||
      !(done = fill(constants_, constants, "constants of elastic cells")) ||
      !(done = fill(gains_, gains[0], "gains of elastic cells")) ||
      !(done = fill(surface_cells_, surface_cells, "elastic surface cells")) ||
      !(done = fill(points_, point_rows, "elastic surface points")) ||
      !(done = reserve(contacts_, surface_cells.size() * sizeof(ContactSumsRow), "elastic contacts")) ||
      !(done = reserve(blocks_, block_bodies.size() * sizeof(NodeSumsRow), "sums of elastic nodes")))
    return done;
  return {};
}

Result<void> DeviceElastic::Fleet::run_steps(uint32_t steps, bool touches, bool backward) {
  const auto rank_count = static_cast<uint32_t>(cell_begins.size() - 1);
  const auto body_items = static_cast<uint32_t>(members.size()) * kElasticBlock;
  ElasticConstants constants{};
  constants.rank_count = rank_count;
  constants.row_count = row_count;
  constants.count = body_items;
  constants.begins = 1;
  if (auto done = dispatch(elastic_ledger_pass(), {bodies_.id(), blocks_.id(), contacts_.id()}, constants);
      !done)
    return done;
  constants.begins = 0;
  // The cells of rank r, and for bodies that sweep backwards those of the mirrored rank.
  const auto set_range = [&](const std::vector<uint32_t>& begins, uint32_t r) {
    const uint32_t mirrored = rank_count - 1 - r;
    constants.rank = r;
    constants.first = begins[r];
    constants.split = begins[r + 1] - begins[r];
    constants.second = begins[mirrored];
    constants.count =
        constants.split + (backward && mirrored != r ? begins[mirrored + 1] - begins[mirrored] : 0);
  };
  for (uint32_t k = 0; k < steps; ++k) {
    const BufferId now = k % 2 == 0 ? now_.id() : before_.id(),
                   before = k % 2 == 0 ? before_.id() : now_.id();
    constants.step = k;
    constants.count = node_rows;
    if (auto done =
            dispatch(elastic_predict_pass(),
                     {bodies_.id(), now, before, solve_.id(), drift_.id(), loads_.id(), block_bodies_.id()},
                     constants);
        !done)
      return done;
    for (uint32_t r = 0; r < rank_count; ++r) {
      set_range(cell_begins, r);
      if (constants.count == 0) continue;
      if (auto done = dispatch(
              elastic_cells_pass(),
              {bodies_.id(), cells_.id(), rotations_.id(), solve_.id(), constants_.id(), gains_.id()},
              constants);
          !done)
        return done;
    }
    for (uint32_t r = 0; touches && r < rank_count; ++r) {
      set_range(surface_begins, r);
      if (constants.count == 0) continue;
      if (auto done = dispatch(elastic_contact_pass(),
                               {bodies_.id(), surface_cells_.id(), points_.id(), now, solve_.id(),
                                drift_.id(), contacts_.id(), colliders_.id()},
                               constants);
          !done)
        return done;
    }
    constants.count = node_rows;
    if (auto done = dispatch(elastic_advance_pass(),
                             {bodies_.id(), now, before, solve_.id(), drift_.id(), loads_.id(), blocks_.id(),
                              block_bodies_.id()},
                             constants);
        !done)
      return done;
    constants.count = body_items;
    if (auto done = dispatch(elastic_ledger_pass(), {bodies_.id(), blocks_.id(), contacts_.id()}, constants);
        !done)
      return done;
  }
  return {};
}

Result<void> DeviceElastic::Fleet::step(std::span<DeviceBody> bodies, const FlatTick& tick) {
  std::vector<DeviceBody*> able;
  for (DeviceBody& one : bodies) {
    one.reason = one.body->flat_obstacle();
    if (!one.reason) able.push_back(&one);
  }
  if (cost) {
    ElasticWork work;
    for (const DeviceBody* one : able) {
      ++work.bodies;
      work.steps = std::max(work.steps, one->body->flat_steps());
      work.node_steps += static_cast<double>(one->body->flat_node_count()) * one->body->flat_steps();
    }
    if (cost->device_ms(work) >= cost->cpu_ms(work)) {
      for (DeviceBody* one : able) one->reason = kCheaper;
      return {};
    }
  }
  const bool same =
      std::equal(able.begin(), able.end(), members.begin(), members.end(),
                 [](const DeviceBody* one, const Member& member) {
                   return one->body == member.body && one->body->flat_revision() == member.revision;
                 });
  if (!same) {
    members.clear();
    for (DeviceBody* one : able) {
      Member& member = members.emplace_back();
      member.body = one->body;
      one->body->write_flat(member.lattice);
      member.revision = one->body->flat_revision();
    }
    if (members.empty()) return {};
    if (auto done = upload_lattices(); !done) {
      members.clear();
      return done;
    }
  }
  if (members.empty()) return {};

  std::vector<BodyRow> body_rows(members.size());
  std::vector<NodeStateRow> now(node_rows), before(node_rows);
  std::vector<vec4> rotations(cell_begins.back()), loads(node_rows);
  std::vector<ColliderRow> colliders;
  uint32_t steps = 0;
  bool has_loads = false, backward = false;
  uint64_t node_steps = 0, taken = 0;
  for (size_t m = 0; m < members.size(); ++m) {
    Member& member = members[m];
    FlatTick own = tick;
    own.forces = able[m]->forces;
    able[m]->reason = member.body->begin_flat_tick(own, member.state);
    FlatState& state = member.state;
    if (able[m]->reason) state.steps = 0;
    if (state.steps == 0) {
      std::memset(static_cast<void*>(&body_rows[m]), 0, sizeof(BodyRow));
      continue;
    }
    ++taken;
    steps = std::max(steps, static_cast<uint32_t>(state.steps));
    node_steps += state.now.size() * static_cast<uint64_t>(state.steps);
    BodyRow& row = body_rows[m];
    row = body_row(state, tick);
    row.first_block = member.first_node / kElasticBlock;
    row.block_count = static_cast<uint>((state.now.size() + kElasticBlock - 1) / kElasticBlock);
    row.first_surface = member.first_surface;
    row.surface_count = static_cast<uint>(member.lattice.surface_cells.size());
    row.first_collider = static_cast<uint>(colliders.size());
    row.collider_count = static_cast<uint>(state.colliders.size());
    for (const FlatCollider& collider : state.colliders) colliders.push_back(collider_row(collider));
    backward = backward || state.touching || !state.colliders.empty();
    std::memcpy(static_cast<void*>(&now[member.first_node]), state.now.data(),
                state.now.size() * sizeof(FlatNode));
    std::memcpy(static_cast<void*>(&before[member.first_node]), state.before.data(),
                state.before.size() * sizeof(FlatNode));
    for (size_t i = 0; i < state.rotations.size(); ++i)
      rotations[member.cell_rows[i]] = row_of(state.rotations[i]);
    for (size_t i = 0; i < state.loads_n.size(); ++i) loads[member.first_node + i] = row_of(state.loads_n[i]);
    has_loads = has_loads || !state.loads_n.empty();
  }
  if (taken == 0) return {};
  Result<void> done;
  if (!(done = fill(bodies_, body_rows, "elastic bodies")) || !(done = fill(now_, now, "elastic nodes")) ||
      !(done = fill(before_, before, "elastic nodes")) ||
      !(done = fill(rotations_, rotations, "rotations of elastic cells")) ||
      !(done = fill(colliders_, colliders, "colliders of elastic bodies")) ||
      ((has_loads || loaded) && !(done = fill(loads_, loads, "elastic loads"))) ||
      !(done = run_steps(steps, !colliders.empty(), backward)) || !(done = read(bodies_, body_rows)) ||
      !(done = read(now_, now)) || !(done = read(before_, before)) || !(done = read(rotations_, rotations)))
    return done;
  loaded = has_loads;

  for (size_t m = 0; m < members.size(); ++m) {
    Member& member = members[m];
    FlatState& state = member.state;
    if (state.steps == 0) continue;
    read_body(body_rows[m], state);
    const bool swapped = state.steps % 2 == 1;
    const size_t bytes = state.now.size() * sizeof(FlatNode);
    std::memcpy(state.now.data(), &(swapped ? before : now)[member.first_node], bytes);
    std::memcpy(state.before.data(), &(swapped ? now : before)[member.first_node], bytes);
    for (size_t i = 0; i < state.rotations.size(); ++i) {
      const vec4& q = rotations[member.cell_rows[i]];
      state.rotations[i] = {q.x, q.y, q.z, q.w};
    }
    FlatTick own = tick;
    own.forces = able[m]->forces;
    member.body->end_flat_tick(own, state);
  }
  ++counts.ticks;
  counts.body_ticks += taken;
  counts.node_steps += node_steps;
  return {};
}

// One line for the first body on the device, and one for each reason that is met.
void DeviceElastic::Fleet::report(std::span<const DeviceBody> bodies) {
  size_t here = 0;
  for (const DeviceBody& one : bodies) here += !one.reason;
  if (here > 0 && reported.insert("").second)
    log_info("physics: %zu of %zu isolated elastic bodies are stepped on the device", here, bodies.size());
  for (const DeviceBody& one : bodies) {
    if (one.reason && reported.insert(one.reason).second)
      log_info("physics: an elastic body is stepped on the CPU: %s", one.reason);
  }
}

DeviceElastic::DeviceElastic(Backend& backend, std::optional<ElasticCost> cost)
    : fleet_(std::make_unique<Fleet>(backend, cost)) {}
DeviceElastic::~DeviceElastic() = default;

void DeviceElastic::step(std::span<DeviceBody> bodies, const FlatTick& tick) {
  const std::lock_guard lock(fleet_->one_call);
  if (fleet_->failure.empty()) {
    const Result<void> done = fleet_->step(bodies, tick);
    if (done) {
      fleet_->report(bodies);
      return;
    }
    fleet_->failure = done.error().message;
    fleet_->members.clear();
    log_warn("physics: the device failed (%s); elastic bodies are stepped on the CPU",
             fleet_->failure.c_str());
  }
  for (DeviceBody& one : bodies) one.reason = "the device failed";
}

const DeviceElastic::Counts& DeviceElastic::counts() const { return fleet_->counts; }
const std::string& DeviceElastic::failure() const { return fleet_->failure; }

}  // namespace livegs
