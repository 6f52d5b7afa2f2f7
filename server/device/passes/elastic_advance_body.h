// SPDX-License-Identifier: GPL-3.0-or-later

// Body of the pass elastic_advance, for GLSL and C++ (shader_math.h): the new state of a node, which replaces
// the one before the last, and its part of the sums.

LIVEGS_SHARED_BODY NodeSumsRow advance_node(uint body, uint i) {
  const float rate = 1.0f / bodies[body].solve_s;
  const vec3 pushed = vec3(drift[i].pushed), moved = vec3(solve[i].swept) + pushed;
  const vec3 x = vec3(solve[i].predicted) + moved, v = vec3(drift[i].speed) + rate * moved;
  const float mass = drift[i].speed.w;
  const vec4 old = now[i].speed;
  // Contact impulses are excluded from the difference v - v_ of BDF2.
  now[i].speed = vec4(vec3(old) + rate * pushed, old.w);
  before[i].place = vec4(x, solve[i].predicted.w);
  before[i].speed = vec4(v, mass);

  const vec3 r = x - vec3(bodies[body].centre), u = v - vec3(bodies[body].mean_m_s);
  NodeSumsRow sums;
  sums.first = vec4(mass * r, 0.0f);
  sums.momentum = vec4(mass * u, 0.5f * mass * dot(u, u));
  sums.angular = vec4(cross(r, mass * u), 0.0f);
  sums.before = vec4(cross(r, mass * (vec3(old) - vec3(bodies[body].before_m_s))), 0.0f);
  sums.squares = vec4(mass * r.x * r.x, mass * r.y * r.y, mass * r.z * r.z, 0.0f);
  sums.products = vec4(mass * r.x * r.y, mass * r.y * r.z, mass * r.z * r.x, 0.0f);
  sums.kicked = vec4(cross(r, mass * rate * pushed), 0.0f);
  sums.load = vec4(cross(r, vec3(loads[i])), 0.0f);
  return sums;
}
