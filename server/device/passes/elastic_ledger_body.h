// SPDX-License-Identifier: GPL-3.0-or-later

// Body of the pass elastic_ledger, for GLSL and C++ (shader_math.h): the motion of a whole body and the
// choice of its next step, as cells_step.cpp, cells_inertia.cpp and cells_rolling_resistance.cpp of
// server/physics/elastic/cells, whose comments have the reasons. Velocities are relative to a mean velocity,
// and momenta have a second word for the part below their last digit, in place of double precision.

LIVEGS_SHARED_BODY mat3 columns_of(vec4 x, vec4 y, vec4 z) { return mat3(vec3(x), vec3(y), vec3(z)); }

// Angular velocity for the angular momentum l; bodies with a negligible moment are not on the device.
LIVEGS_SHARED_BODY vec3 spin_of(mat3 inertia, vec3 l) {
  const float scale = inertia[0].x + inertia[1].y + inertia[2].z;
  if (!(scale > 0.0f)) return vec3(0.0f);
  const mat3 m = (1.0f / scale) * inertia;
  const vec3 yz = cross(m[1], m[2]), zx = cross(m[2], m[0]), xy = cross(m[0], m[1]);
  const float det = dot(m[0], yz);
  if (!(abs(det) > 0.0f)) return vec3(0.0f);
  const vec3 per = (1.0f / scale) * l;
  return (1.0f / det) * vec3(dot(yz, per), dot(zx, per), dot(xy, per));
}

LIVEGS_SHARED_BODY mat3 turn_of_quaternion(vec4 q) {
  const float x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const float xx = q.x * x2, yy = q.y * y2, zz = q.z * z2, xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const float wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  return mat3(vec3(1.0f - yy - zz, xy + wz, xz - wy), vec3(xy - wz, 1.0f - xx - zz, yz + wx),
              vec3(xz + wy, yz - wx, 1.0f - xx - yy));
}

// Adds to a vector of two words (Knuth's two-sum).
LIVEGS_SHARED_BODY void add_exactly(LIVEGS_INOUT(vec4) high, LIVEGS_INOUT(vec4) low, vec3 by) {
  LIVEGS_PRECISE vec3 sum = vec3(high) + by;
  LIVEGS_PRECISE vec3 part = sum - vec3(high);
  LIVEGS_PRECISE vec3 lost = (vec3(high) - (sum - part)) + (by - part);
  LIVEGS_PRECISE vec3 rest = vec3(low) + lost;
  LIVEGS_PRECISE vec3 whole = sum + rest;
  LIVEGS_PRECISE vec3 left = rest - (whole - sum);
  high = vec4(whole, 0.0f);
  low = vec4(left, 0.0f);
}

LIVEGS_SHARED_BODY mat3 moment_map(BodyRow b) {
  const mat3 turn = turn_of_quaternion(b.orientation);
  const mat3 map = columns_of(b.map_x, b.map_y, b.map_z);
  return turn * map * transpose(turn);
}

// Chooses the next step and the parameters of its prediction.
LIVEGS_SHARED_BODY void begin_step(uint i) {
  BodyRow b = bodies[i];
  const bool held = (b.flags & kBodyHeld) != 0u;
  const float h = b.step_s;
  const bool slow = b.touching != 0u && b.deviation_m_s < b.slow_m_s;
  const bool second =
      (b.flags & kBodySecondOrder) != 0u && b.first == 0u && b.uneven == 0u && b.strained == 0u && !slow;
  b.slow = slow ? 1u : 0u;
  b.second_order = second ? 1u : 0u;
  b.backward = b.touching != 0u && !slow && b.backward == 0u ? 1u : 0u;
  b.uneven = 0u;
  b.touching = 0u;
  b.strain_bits = b.bent_bits = b.lack_bits = 0u;
  const float memory = second ? 1.0f / 3.0f : 0.0f, step_s = second ? 2.0f * h / 3.0f : h;
  b.memory = memory;
  b.solve_s = step_s;
  const float loaded = b.weight_n > 0.0f ? sqrt(1.0f + b.carried_n / (b.moving_part * b.weight_n)) : 1.0f;
  b.kept = max(0.0f, 1.0f - step_s * (loaded - 1.0f) * b.damping_per_s) / (1.0f + step_s * b.damping_per_s);

  vec3 bias = step_s * vec3(b.gravity), spin = vec3(0.0f);
  mat3 field = mat3(0.0f);
  b.mean_m_s = b.before_m_s = b.turning = vec4(0.0f);
  if (!held) {
    const mat3 inertia = columns_of(b.inertia_x, b.inertia_y, b.inertia_z),
               of_nodes = columns_of(b.nodes_x, b.nodes_y, b.nodes_z);
    const float per_kg = 1.0f / b.mass_kg;
    const vec3 momentum = vec3(b.momentum), angular = vec3(b.angular);
    const vec3 force = b.mass_kg * vec3(b.gravity) + vec3(b.load_n), torque = vec3(b.load_torque);
    const vec3 old_velocity =
        per_kg * (momentum + memory * ((momentum - vec3(b.momentum_before)) + vec3(b.momentum_low)));
    const vec3 old_spin =
        spin_of(inertia, angular + memory * ((angular - vec3(b.angular_before)) + vec3(b.angular_low)));
    const vec3 turning = spin_of(inertia, angular);
    b.before_m_s = vec4(per_kg * momentum, 0.0f);
    b.turning = vec4(turning, 0.0f);
    b.momentum_before = b.momentum;
    b.angular_before = b.angular;
    add_exactly(b.momentum, b.momentum_low, vec3(b.push_n_s));
    add_exactly(b.momentum, b.momentum_low, vec3(b.push_low));
    add_exactly(b.angular, b.angular_low, h * torque);
    b.mean_m_s = vec4(per_kg * vec3(b.momentum), 0.0f);
    const vec3 new_velocity = per_kg * (vec3(b.momentum) - step_s * force);
    const vec3 new_spin = spin_of(inertia, vec3(b.angular)) - step_s * spin_of(of_nodes, torque);
    bias = bias + (new_velocity - b.kept * old_velocity);
    spin = new_spin - b.kept * old_spin;
    if (b.strained == 0u) {
      const mat3 map = moment_map(b);
      const mat3 pull = dot(turning, turning) * mat3(1.0f) - outerProduct(turning, turning);
      field = step_s * (map * pull * map - pull);
    }
  }
  b.correction = b.velocity_correction;
  b.correction_spin = b.spin_correction;
  b.bias = vec4(bias, 0.0f);
  b.spin = vec4(spin, 0.0f);
  b.field_x = vec4(field[0], 0.0f);
  b.field_y = vec4(field[1], 0.0f);
  b.field_z = vec4(field[2], 0.0f);
  bodies[i] = b;
}

// The couple against rolling, for flat patches.
LIVEGS_SHARED_BODY vec3 rolling_couple(BodyRow b, ContactSumsRow contact) {
  const vec3 spin = vec3(b.turning), push = vec3(contact.impulse);
  const float speed_squared = dot(spin, spin), through = length(push), pressed = contact.impulse.w;
  if (!(speed_squared > 0.0f) || !(through > 0.0f)) return vec3(0.0f);
  const vec3 centre = (1.0f / pressed) * vec3(contact.rolled), normal = (1.0f / through) * push;
  const float per = 1.0f / pressed, xy = per * contact.products.x - centre.x * centre.y,
              yz = per * contact.products.y - centre.y * centre.z,
              zx = per * contact.products.z - centre.z * centre.x;
  const mat3 spread = mat3(vec3(per * contact.squares.x - centre.x * centre.x, xy, zx),
                           vec3(xy, per * contact.squares.y - centre.y * centre.y, yz),
                           vec3(zx, yz, per * contact.squares.z - centre.z * centre.z));
  const mat3 across =
      mat3(vec3(0.0f, normal.z, -normal.y), vec3(-normal.z, 0.0f, normal.x), vec3(normal.y, -normal.x, 0.0f));
  const vec3 rolling = spin - dot(normal, spin) * normal,
             rolled = across * (spread * (transpose(across) * spin));
  const float speed = sqrt(max(0.0f, dot(spin, rolled)));
  if (!(speed > 0.0f)) return vec3(0.0f);
  const vec3 axis = (1.0f / sqrt(speed_squared)) * spin;
  const mat3 inertia = columns_of(b.inertia_x, b.inertia_y, b.inertia_z);
  const float stop = min(1.0f, b.solve_s / 0.02f) * dot(axis, inertia * axis);
  const float lost = min(1.0f, 6.2831853f * b.loss_factor), most = 3.0f / 16.0f * lost * through * 2.2360680f;
  if (most * speed >= stop * dot(rolling, rolling)) return -stop * spin;
  return (-most / speed) * rolled;
}

// Ends a step with the sums over its nodes and contacts.
LIVEGS_SHARED_BODY void finish_step(uint i, NodeSumsRow total, ContactSumsRow contact) {
  BodyRow b = bodies[i];
  const bool held = (b.flags & kBodyHeld) != 0u;
  const float h = b.step_s, per_kg = 1.0f / b.mass_kg;
  const vec3 impulse = vec3(contact.impulse), centre_before = vec3(b.centre);
  vec3 moment = vec3(contact.moment);
  b.touching = contact.moment.w > 0.0f ? 1u : 0u;

  b.strained = uintBitsToFloat(b.strain_bits) > 0.25f || uintBitsToFloat(b.lack_bits) > 0.8f ? 1u : 0u;
  b.ever_strained = b.ever_strained != 0u || b.strained != 0u ? 1u : 0u;

  if (!held && b.slow != 0u) moment = moment + rolling_couple(b, contact);
  const float pressed = contact.impulse.w, sum = length(impulse);
  const float through = pressed / sqrt(1.0f + b.friction * b.friction) - sum;
  const float part_of_mean = h / (h + 0.25f), carried = 0.5f * max(0.0f, through) + (held ? sum : 0.0f);
  b.pressed_n += part_of_mean * (pressed / h - b.pressed_n);
  b.carried_n += part_of_mean * (carried / h - b.carried_n);
  b.contact_n_s += pressed;
  b.contact_moment = vec4(vec3(b.contact_moment) + vec3(contact.at) + pressed * centre_before, 0.0f);

  const vec3 moved = per_kg * vec3(total.first), c = moved;
  b.centre = vec4(centre_before + moved, 0.0f);
  const vec3 relative = vec3(total.momentum);
  const vec3 of_nodes = vec3(total.angular) - cross(c, relative);  // about the centre
  const float m = b.mass_kg;
  const float xx = total.squares.x - m * c.x * c.x, yy = total.squares.y - m * c.y * c.y,
              zz = total.squares.z - m * c.z * c.z, xy = total.products.x - m * c.x * c.y,
              yz = total.products.y - m * c.y * c.z, zx = total.products.z - m * c.z * c.x;
  const mat3 second = mat3(vec3(xx, xy, zx), vec3(xy, yy, yz), vec3(zx, yz, zz));
  const mat3 node_inertia = (xx + yy + zz) * mat3(1.0f) - second;
  mat3 inertia = node_inertia;
  // Turns with the spin before the step.
  const vec3 angle = h * vec3(b.turning);
  const float turned = length(angle), by = turned > 1e-4f ? sin(0.5f * turned) / turned : 0.5f;
  const vec4 p = vec4(by * angle, cos(0.5f * turned)), q = b.orientation;
  const vec4 n =
      vec4(p.w * vec3(q) + q.w * vec3(p) + cross(vec3(p), vec3(q)), p.w * q.w - dot(vec3(p), vec3(q)));
  b.orientation = inverse_root(dot(n, n)) * n;
  if (!held && b.strained == 0u) {
    const mat3 map = moment_map(b), mapped = map * second * map;
    inertia = (mapped[0].x + mapped[1].y + mapped[2].z) * mat3(1.0f) - mapped;
  }
  b.inertia_x = vec4(inertia[0], 0.0f);
  b.inertia_y = vec4(inertia[1], 0.0f);
  b.inertia_z = vec4(inertia[2], 0.0f);
  b.nodes_x = vec4(node_inertia[0], 0.0f);
  b.nodes_y = vec4(node_inertia[1], 0.0f);
  b.nodes_z = vec4(node_inertia[2], 0.0f);
  vec3 spin = spin_of(node_inertia, of_nodes);
  if (held) {
    b.momentum = vec4(relative, 0.0f);
    b.angular = vec4(of_nodes, 0.0f);
    b.momentum_low = b.angular_low = vec4(0.0f);
  } else {
    const vec3 nodes_spin = spin;  // of the material as well
    b.velocity_correction = vec4(per_kg * (impulse - relative), 0.0f);
    add_exactly(b.momentum, b.momentum_low, impulse);
    const vec3 lag = (b.second_order != 0u ? 1.0f / 3.0f : 0.0f) *
                     (vec3(b.contact_lag_m) - h * per_kg * (impulse + vec3(b.between_n_s)));
    b.contact_lag_m = vec4(lag, 0.0f);
    b.between_n_s = vec4(0.0f);
    add_exactly(b.angular, b.angular_low, moment - cross(lag, vec3(b.momentum)));
    spin = spin_of(inertia, vec3(b.angular));
    b.spin_correction = vec4(spin - nodes_spin, 0.0f);
    // Velocities before the step, with the contact impulses of this step.
    const vec3 kicked = vec3(total.kicked) - cross(moved, impulse);
    b.momentum_before = vec4(vec3(b.momentum_before) + impulse, 0.0f);
    b.angular_before = vec4(inertia * spin_of(node_inertia, vec3(total.before)) + kicked, 0.0f);
  }
  b.load_torque = vec4(vec3(total.load) - cross(moved, vec3(b.load_n)), 0.0f);
  const float rest_j =
      total.momentum.w - 0.5f * per_kg * dot(relative, relative) - 0.5f * dot(spin, node_inertia * spin);
  b.deviation_m_s = sqrt(max(0.0f, 2.0f * rest_j * per_kg));
  b.first = 0u;
  bodies[i] = b;
}
