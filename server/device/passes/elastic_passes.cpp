// SPDX-License-Identifier: GPL-3.0-or-later
#include "device/passes/elastic_passes.h"

#include <array>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "device/passes/elastic_sums.h"
#include "elastic_advance.spv.h"
#include "elastic_cells.spv.h"
#include "elastic_contact.spv.h"
#include "elastic_ledger.spv.h"
#include "elastic_predict.spv.h"

namespace livegs {

namespace shader {

// The bindings of each shader under their names there.
struct PredictPass {
  BodyRow* bodies;
  NodeStateRow *now, *before;
  NodeSolveRow* solve;
  NodeDriftRow* drift;
  vec4* loads;
  uint* block_bodies;
#include "device/passes/elastic_nodes_body.h"
};
struct CellsPass {
  BodyRow* bodies;
  CellRow* cells;
  vec4* rotations;
  NodeSolveRow* solve;
  float *rows, *gains;
#include "device/passes/elastic_cells_body.h"
};
struct ContactPass {
  BodyRow* bodies;
  SurfaceCellRow* cells;
  SurfacePointRow* points;
  NodeStateRow* now;
  NodeSolveRow* solve;
  NodeDriftRow* drift;
  ContactSumsRow* contacts;
  ColliderRow* colliders;
#include "device/passes/elastic_contact_body.h"
};
struct AdvancePass {
  BodyRow* bodies;
  NodeStateRow *now, *before;
  NodeSolveRow* solve;
  NodeDriftRow* drift;
  vec4* loads;
  NodeSumsRow* blocks;
  uint* block_bodies;
#include "device/passes/elastic_advance_body.h"
};
struct LedgerPass {
  BodyRow* bodies;
  NodeSumsRow* blocks;
  ContactSumsRow* contacts;
#include "device/passes/elastic_ledger_body.h"
};

}  // namespace shader

namespace {

using namespace shader;

// Buffers are aligned to 16 bytes and come from operator new as plain bytes.
template <class Row>
Row* rows_of(const PassArguments& arguments, size_t binding) {
  return reinterpret_cast<Row*>(arguments.buffers[binding].data());
}

uint row_of(const ElasticConstants& constants, size_t i) {
  const uint item = static_cast<uint>(i);
  return item < constants.split ? constants.first + item : constants.second + (item - constants.split);
}

// Halves the rows until the first is their sum, in the order of the shader.
template <class Row>
void add_up(std::array<Row, kElasticBlock>& rows) {
  for (uint stride = kElasticBlock / 2; stride > 0; stride /= 2) {
    for (uint k = 0; k < stride; ++k) rows[k] = sum_of(rows[k], rows[k + stride]);
  }
}

void run_predict(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<ElasticConstants>(arguments.constants, 0);
  PredictPass pass{rows_of<BodyRow>(arguments, 0),      rows_of<NodeStateRow>(arguments, 1),
                   rows_of<NodeStateRow>(arguments, 2), rows_of<NodeSolveRow>(arguments, 3),
                   rows_of<NodeDriftRow>(arguments, 4), rows_of<vec4>(arguments, 5),
                   rows_of<uint>(arguments, 6)};
  LIVEGS_ASSERT(constants.count * sizeof(NodeStateRow) <= arguments.buffers[1].size());
  for (size_t i = begin; i < std::min<size_t>(end, constants.count); ++i) {
    const uint body = pass.block_bodies[i / kElasticBlock];
    if (constants.step < pass.bodies[body].steps) pass.predict_node(body, static_cast<uint>(i));
  }
}

void run_cells(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<ElasticConstants>(arguments.constants, 0);
  CellsPass pass{rows_of<BodyRow>(arguments, 0), rows_of<CellRow>(arguments, 1),
                 rows_of<vec4>(arguments, 2),    rows_of<NodeSolveRow>(arguments, 3),
                 rows_of<float>(arguments, 4),   rows_of<float>(arguments, 5)};
  for (size_t i = begin; i < std::min<size_t>(end, constants.count); ++i) {
    pass.solve_cell(row_of(constants, i), constants.step, constants.rank, constants.rank_count,
                    constants.row_count);
  }
}

void run_contact(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<ElasticConstants>(arguments.constants, 0);
  ContactPass pass{rows_of<BodyRow>(arguments, 0),         rows_of<SurfaceCellRow>(arguments, 1),
                   rows_of<SurfacePointRow>(arguments, 2), rows_of<NodeStateRow>(arguments, 3),
                   rows_of<NodeSolveRow>(arguments, 4),    rows_of<NodeDriftRow>(arguments, 5),
                   rows_of<ContactSumsRow>(arguments, 6),  rows_of<ColliderRow>(arguments, 7)};
  for (size_t i = begin; i < std::min<size_t>(end, constants.count); ++i) {
    pass.resolve_cell(row_of(constants, i), constants.step, constants.rank, constants.rank_count);
  }
}

void run_advance(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<ElasticConstants>(arguments.constants, 0);
  AdvancePass pass{rows_of<BodyRow>(arguments, 0),      rows_of<NodeStateRow>(arguments, 1),
                   rows_of<NodeStateRow>(arguments, 2), rows_of<NodeSolveRow>(arguments, 3),
                   rows_of<NodeDriftRow>(arguments, 4), rows_of<vec4>(arguments, 5),
                   rows_of<NodeSumsRow>(arguments, 6),  rows_of<uint>(arguments, 7)};
  LIVEGS_ASSERT(constants.count * sizeof(NodeStateRow) <= arguments.buffers[1].size());
  std::array<NodeSumsRow, kElasticBlock> parts;
  for (size_t i = begin; i < std::min<size_t>(end, constants.count); i += kElasticBlock) {
    const uint block = static_cast<uint>(i / kElasticBlock), body = pass.block_bodies[block];
    if (constants.step >= pass.bodies[body].steps) continue;
    for (uint k = 0; k < kElasticBlock; ++k) parts[k] = pass.advance_node(body, static_cast<uint>(i) + k);
    add_up(parts);
    pass.blocks[block] = parts[0];
  }
}

void run_ledger(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<ElasticConstants>(arguments.constants, 0);
  LedgerPass pass{rows_of<BodyRow>(arguments, 0), rows_of<NodeSumsRow>(arguments, 1),
                  rows_of<ContactSumsRow>(arguments, 2)};
  std::array<NodeSumsRow, kElasticBlock> nodes;
  std::array<ContactSumsRow, kElasticBlock> contacts;
  for (size_t i = begin; i < std::min<size_t>(end, constants.count); i += kElasticBlock) {
    const uint index = static_cast<uint>(i / kElasticBlock);
    BodyRow& body = pass.bodies[index];
    if (constants.step >= body.steps) continue;
    if (constants.begins != 0) {
      pass.begin_step(index);
      continue;
    }
    nodes.fill(no_node_sums());
    contacts.fill(no_contact_sums());
    for (uint k = 0; k < body.block_count; ++k) {
      NodeSumsRow& sum = nodes[k % kElasticBlock];
      sum = sum_of(sum, pass.blocks[body.first_block + k]);
    }
    for (uint k = 0; body.collider_count > 0 && k < body.surface_count; ++k) {
      ContactSumsRow& sum = contacts[k % kElasticBlock];
      sum = sum_of(sum, pass.contacts[body.first_surface + k]);
    }
    add_up(nodes);
    add_up(contacts);
    pass.finish_step(index, nodes[0], contacts[0]);
    if (constants.step + 1 < body.steps) pass.begin_step(index);
  }
}

Pass pass_of(std::string_view name, uint32_t buffer_count, std::span<const uint32_t> spirv,
             void (*run)(const PassArguments&, size_t, size_t)) {
  return {.name = name,
          .group_size = kElasticBlock,
          .buffer_count = buffer_count,
          .constants_bytes = sizeof(ElasticConstants),
          .spirv = spirv,
          .run = run};
}

}  // namespace

const Pass& elastic_predict_pass() {
  static const Pass pass = pass_of("elastic_predict", 7, elastic_predict_spirv, run_predict);
  return pass;
}
const Pass& elastic_cells_pass() {
  static const Pass pass = pass_of("elastic_cells", 6, elastic_cells_spirv, run_cells);
  return pass;
}
const Pass& elastic_contact_pass() {
  static const Pass pass = pass_of("elastic_contact", 8, elastic_contact_spirv, run_contact);
  return pass;
}
const Pass& elastic_advance_pass() {
  static const Pass pass = pass_of("elastic_advance", 8, elastic_advance_spirv, run_advance);
  return pass;
}
const Pass& elastic_ledger_pass() {
  static const Pass pass = pass_of("elastic_ledger", 3, elastic_ledger_spirv, run_ledger);
  return pass;
}

}  // namespace livegs
