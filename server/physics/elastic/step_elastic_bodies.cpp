// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/step_elastic_bodies.h"

#include <algorithm>
#include <vector>

#include "core/parallel_for.h"
#include "physics/elastic/rigid_proxy.h"

namespace livegs {

void step_elastic_bodies(std::span<SteppedBody> bodies) {
  int count = 0;
  for (SteppedBody& stepped : bodies) {
    stepped.steps = stepped.body->begin_substep(stepped.context);
    count = std::max(count, stepped.steps);
  }
  if (count == 0) return;
  std::vector<RigidProxy*> moving;
  for (const SteppedBody& stepped : bodies) {
    moving.insert(moving.end(), stepped.context.bodies.begin(), stepped.context.bodies.end());
  }
  std::ranges::sort(moving, {}, &RigidProxy::body_id);
  moving.erase(std::unique(moving.begin(), moving.end()), moving.end());

  const double substep_s = bodies.front().context.duration_s;
  std::vector<ContactConstraint*> rows;
  // `visit` changes only its own body. A thread takes at least 4 at a time: fewer are not worth a second
  // thread.
  const size_t block = std::max<size_t>(4, bodies.size() / 16 + 1);
  const auto for_each_body = [&](const auto& visit) {
    parallel_for(bodies.size(), block, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        if (bodies[i].steps > 0) visit(bodies[i]);
      }
    });
  };
  for (int k = 0; k < count; ++k) {
    const SubstepPart part{k * (substep_s / count), substep_s / count};
    for (SteppedBody& stepped : bodies) {
      // A sleeping body that was pushed in the last step takes part from this step on.
      if (stepped.steps == 0 && k > 0 && !stepped.body->asleep()) {
        stepped.steps = stepped.body->begin_substep(stepped.context);
      }
    }
    for_each_body([&](SteppedBody& stepped) { stepped.body->begin_step(part, stepped.context); });
    for (RigidProxy* body : moving) body->begin_step(part.began_s, part.duration_s, substep_s);
    parallel_for(bodies.size(), block, [&](size_t begin, size_t end) {
      for (SteppedBody& stepped : bodies.subspan(begin, end - begin)) {
        stepped.rows->clear();
        stepped.body->prepare_contact_step(part.duration_s);
      }
    });
    for_each_body(
        [&](SteppedBody& stepped) { stepped.body->list_contacts(part, stepped.context, *stepped.rows); });
    for (SteppedBody& stepped : bodies) {
      if (stepped.steps > 0) stepped.body->separate(part, stepped.context, *stepped.rows);
    }
    rows.clear();
    for (const SteppedBody& stepped : bodies) {
      for (ContactConstraint& row : *stepped.rows) rows.push_back(&row);
    }
    if (!rows.empty()) solve_contacts(rows, part.duration_s);
    // Rolling resistance turns balls, which other bodies may touch too: then one body after the other.
    const auto read_impulses = [](SteppedBody& stepped) {
      stepped.body->read_contact_impulses(*stepped.rows);
    };
    if (moving.empty()) {
      for_each_body(read_impulses);
    } else {
      for (SteppedBody& stepped : bodies) {
        if (stepped.steps > 0) read_impulses(stepped);
      }
    }
    for_each_body([&](SteppedBody& stepped) {
      if (std::vector<uint64_t>* ids = stepped.context.touched_ids) {
        for (const ContactConstraint& row : *stepped.rows) {
          const bool is_new = ids->empty() || ids->back() != row.other_body_id;
          if (row.normal_impulse_n_s > 0.0 && is_new) ids->push_back(row.other_body_id);
        }
      }
      stepped.body->end_step(part, stepped.context);
    });
  }
  for (SteppedBody& stepped : bodies) {
    if (stepped.steps > 0) stepped.body->end_substep(stepped.context);
  }
}

// Defined here because ElasticBody is a lower layer than the solver of several bodies.
void ElasticBody::substep(const SubstepContext& context) {
  std::vector<ContactConstraint> rows;
  SteppedBody alone{this, context, &rows};
  step_elastic_bodies({&alone, 1});
}

}  // namespace livegs
