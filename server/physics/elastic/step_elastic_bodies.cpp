// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/step_elastic_bodies.h"

#include <algorithm>
#include <vector>

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
  std::sort(moving.begin(), moving.end(),
            [](const RigidProxy* a, const RigidProxy* b) { return a->body_id < b->body_id; });
  moving.erase(std::unique(moving.begin(), moving.end()), moving.end());

  const double substep_s = bodies.front().context.duration_s;
  std::vector<ContactConstraint> rows;
  std::vector<size_t> row_ends(bodies.size());
  for (int k = 0; k < count; ++k) {
    const SubstepPart part{k * (substep_s / count), substep_s / count};
    for (SteppedBody& stepped : bodies) {
      // A sleeping body that was pushed in the last step takes part from this step on.
      if (stepped.steps == 0 && k > 0 && !stepped.body->asleep()) {
        stepped.steps = stepped.body->begin_substep(stepped.context);
      }
      if (stepped.steps > 0) stepped.body->begin_step(part, stepped.context);
    }
    for (RigidProxy* body : moving) body->begin_step(part.began_s, part.duration_s, substep_s);
    rows.clear();
    for (size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].steps > 0) bodies[i].body->list_contacts(part, bodies[i].context, rows);
      row_ends[i] = rows.size();
    }
    if (!rows.empty()) solve_contacts(rows, part.duration_s);
    for (size_t i = 0, begin = 0; i < bodies.size(); begin = row_ends[i++]) {
      const std::span listed(rows.begin() + static_cast<std::ptrdiff_t>(begin),
                             rows.begin() + static_cast<std::ptrdiff_t>(row_ends[i]));
      if (bodies[i].steps > 0) bodies[i].body->read_contact_impulses(listed);
      if (!bodies[i].context.touched_ids) continue;
      for (const ContactConstraint& row : listed) {
        if (row.normal_impulse_n_s > 0.0) bodies[i].context.touched_ids->push_back(row.other_body_id);
      }
    }
    for (SteppedBody& stepped : bodies) {
      if (stepped.steps > 0) stepped.body->end_step(part, stepped.context);
    }
  }
  for (SteppedBody& stepped : bodies) {
    if (stepped.steps > 0) stepped.body->end_substep(stepped.context);
  }
}

// Defined here because ElasticBody is a lower layer than the solver of several bodies.
void ElasticBody::substep(const SubstepContext& context) {
  SteppedBody alone{this, context};
  step_elastic_bodies({&alone, 1});
}

}  // namespace livegs
