// SPDX-License-Identifier: GPL-3.0-or-later

// Body of the pass elastic_contact, for GLSL and C++ (shader_math.h): the contacts of one surface cell with
// the colliders near its body, as CellsBody::resolve_colliders (server/physics/elastic/cells), and the same
// order: surface cells of one colour share no node.

struct SurfaceHit {
  float distance_m;
  vec3 normal;
};

LIVEGS_SHARED_BODY SurfaceHit sample_collider(uint k, vec3 point) {
  const uint kind = uint(colliders[k].axis_x.w);
  const mat3 turn = mat3(vec3(colliders[k].axis_x), vec3(colliders[k].axis_y), vec3(colliders[k].axis_z));
  const vec3 away = point - vec3(colliders[k].at);
  SurfaceHit hit;
  if (kind == kPlane) {
    hit.normal = turn[1];
    hit.distance_m = dot(turn[1], away);
    return hit;
  }
  if (kind == kSphere) {
    const float radius = length(away);
    hit.normal = radius > 0.0f ? (1.0f / radius) * away : turn[1];
    hit.distance_m = radius - colliders[k].size.x;
    return hit;
  }
  const vec3 local = transpose(turn) * away, half_m = vec3(colliders[k].size);
  const vec3 beyond = vec3(abs(local.x) - half_m.x, abs(local.y) - half_m.y, abs(local.z) - half_m.z);
  const vec3 sign_m =
      vec3(local.x < 0.0f ? -1.0f : 1.0f, local.y < 0.0f ? -1.0f : 1.0f, local.z < 0.0f ? -1.0f : 1.0f);
  const float depth = max(beyond.x, max(beyond.y, beyond.z));
  if (depth <= 0.0f) {
    const uint axis = beyond.x >= depth ? 0u : beyond.y >= depth ? 1u : 2u;
    hit.normal = axis == 0u ? sign_m.x * turn[0] : axis == 1u ? sign_m.y * turn[1] : sign_m.z * turn[2];
    hit.distance_m = depth;
    return hit;
  }
  const vec3 out_m =
      vec3(sign_m.x * max(beyond.x, 0.0f), sign_m.y * max(beyond.y, 0.0f), sign_m.z * max(beyond.z, 0.0f));
  hit.distance_m = length(out_m);
  hit.normal = turn * ((1.0f / hit.distance_m) * out_m);
  return hit;
}

// swept_surface and cast_sphere (server/physics/collision).
LIVEGS_SHARED_BODY SurfaceHit sweep_collider(uint k, vec3 from, vec3 to) {
  const SurfaceHit at = sample_collider(k, to);
  const vec3 moved = to - from;
  const float thickness = colliders[k].size.w, path = length(moved), tolerance = 0.01f * thickness;
  if (!(thickness > 0.0f) || !(path > 0.2f * thickness)) return at;
  SurfaceHit hit;
  const vec3 direction = (1.0f / path) * moved;
  float travelled = 0.0f;
  for (int march = 0; march < 64 && travelled <= path; ++march) {
    const SurfaceHit met = sample_collider(k, from + travelled * direction);
    const float slope = dot(met.normal, direction);
    if (met.distance_m < tolerance && slope < -1e-3f) {
      hit.normal = met.normal;
      hit.distance_m = met.distance_m - travelled * slope + dot(met.normal, moved);
      return hit;
    }
    travelled += max(met.distance_m, max(tolerance, met.distance_m < tolerance ? path / 64.0f : 0.0f));
  }
  return at;
}

LIVEGS_SHARED_BODY float weight_of(uint point, uint corner) {
  const vec4 four = corner < 4u ? points[point].low : points[point].high;
  const uint k = corner & 3u;
  return k == 0u ? four.x : k == 1u ? four.y : k == 2u ? four.z : four.w;
}

LIVEGS_SHARED_BODY vec3 corrected_of(uint i, uint point) {
  vec3 sum = vec3(0.0f);
  for (uint c = 0u; c < 8u; ++c) {
    const uint node = cells[i].nodes[c];
    sum += weight_of(point, c) *
           (vec3(solve[node].predicted) + vec3(solve[node].swept) + vec3(drift[node].pushed));
  }
  return sum;
}

LIVEGS_SHARED_BODY void resolve_point(uint i, uint point, uint body, uint collider,
                                      LIVEGS_INOUT(ContactSumsRow) sums) {
  const uint k = bodies[body].first_collider + collider;
  const float step_s = bodies[body].solve_s;
  const vec3 to = corrected_of(i, point);
  vec3 from = vec3(0.0f);
  for (uint c = 0u; c < 8u; ++c) from += weight_of(point, c) * vec3(now[cells[i].nodes[c]].place);
  const SurfaceHit hit = sweep_collider(k, from, to);
  if (hit.distance_m >= 0.0f) return;
  sums.moment.w = 1.0f;
  // Initial overlaps separate at 0.5 m/s at most (kMaxRigidSeparation_m_s).
  const vec3 moved = to - from;
  const float gap_before = hit.distance_m - dot(hit.normal, moved), mobility = points[point].mobility.x;
  const float depth = min(0.0f, gap_before + 0.5f * step_s) - hit.distance_m;
  if (depth <= 0.0f || mobility <= 0.0f) return;
  // contact_correction: out of the solid, and back by friction.
  const vec3 slid = moved - dot(hit.normal, moved) * hit.normal;
  const float displacement = length(slid), hold = colliders[k].at.w * depth;
  const float part = displacement > hold ? hold / displacement : 1.0f;
  const vec3 pull = (1.0f / mobility) * (depth * hit.normal - part * slid);
  for (uint c = 0u; c < 8u; ++c) {
    const uint node = cells[i].nodes[c];
    const float gained = weight_of(point, c) * solve[node].predicted.w;
    drift[node].pushed = vec4(vec3(drift[node].pushed) + gained * pull, 0.0f);
  }
  const vec3 impulse = (1.0f / step_s) * pull, centre = vec3(bodies[body].centre);
  const float size = length(impulse);
  const vec3 r = to - centre, rolled = r + mobility * pull;
  ContactSumsRow one;
  one.impulse = vec4(impulse, size);
  one.moment = vec4(cross(r, impulse), 0.0f);
  one.at = vec4(size * r, 0.0f);
  one.rolled = vec4(size * rolled, 0.0f);
  one.squares =
      vec4(size * rolled.x * rolled.x, size * rolled.y * rolled.y, size * rolled.z * rolled.z, 0.0f);
  one.products =
      vec4(size * rolled.x * rolled.y, size * rolled.y * rolled.z, size * rolled.z * rolled.x, 0.0f);
  sums = sum_of(sums, one);
}

LIVEGS_SHARED_BODY void resolve_cell(uint i, uint step, uint rank, uint rank_count) {
  const uint body = cells[i].body;
  if (step >= bodies[body].steps || bodies[body].collider_count == 0u) return;
  const bool backward = bodies[body].backward != 0u;
  if (cells[i].rank != (backward ? rank_count - 1u - rank : rank)) return;
  const uint count = cells[i].end - cells[i].begin, collider_count = bodies[body].collider_count;
  ContactSumsRow sums = no_contact_sums();
  for (uint n = 0u; n < collider_count; ++n) {
    for (uint k = 0u; k < count; ++k) {
      resolve_point(i, backward ? cells[i].end - 1u - k : cells[i].begin + k, body,
                    backward ? collider_count - 1u - n : n, sums);
    }
  }
  contacts[cells[i].sums] = sums;
}
