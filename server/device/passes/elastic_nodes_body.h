// SPDX-License-Identifier: GPL-3.0-or-later

// Bodies of the passes elastic_predict and elastic_advance, for GLSL and C++ (shader_math.h): the loops over
// nodes of server/physics/elastic/cells/kernels/node_kernels.h.

LIVEGS_SHARED_BODY void predict_node(uint body, uint i) {
  const vec4 place = now[i].place;
  vec4 speed = now[i].speed;
  const vec4 place_before = before[i].place, speed_before = before[i].speed;
  const vec3 r = vec3(place) - vec3(bodies[body].centre);
  vec3 moved = vec3(0.0f), predicted = vec3(0.0f);
  if (place.w > 0.0f) {
    const float memory = bodies[body].memory, step_s = bodies[body].solve_s;
    const vec3 v = vec3(speed) + vec3(bodies[body].correction) + cross(vec3(bodies[body].correction_spin), r);
    predicted = bodies[body].kept * (v + memory * (v - vec3(speed_before))) + vec3(bodies[body].bias) +
                cross(vec3(bodies[body].spin), r) +
                (r.x * vec3(bodies[body].field_x) + r.y * vec3(bodies[body].field_y) +
                 r.z * vec3(bodies[body].field_z));
    moved = memory * (vec3(place) - vec3(place_before)) + step_s * predicted;
    const vec3 gained = step_s * place.w * vec3(loads[i]);
    predicted = predicted + gained;
    moved = moved + step_s * gained;
    speed = vec4(v, speed.w);
  }
  now[i].speed = speed;
  solve[i].predicted = vec4(vec3(place) + moved, place.w);
  solve[i].swept = vec4(0.0f);
  drift[i].speed = vec4(predicted, speed.w);
  drift[i].pushed = vec4(0.0f);
}
