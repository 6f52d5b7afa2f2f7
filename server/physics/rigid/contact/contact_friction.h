// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>

#include "physics/rigid/contact/contact_point.h"

// Coulomb friction of the points of a contact, in the plane of the contact. `Real` is double, or a vector of
// doubles with one contact per lane.

namespace livegs {

// Functions in place of operators. A vector type specialises it.
template <typename Real>
struct FrictionMath {
  static bool every(bool mask) { return mask; }
  static Real root(Real a) { return std::sqrt(a); }
  static Real size(Real a) { return std::abs(a); }
};

// A motion of the first body relative to the other (m/s, rad/s), or an impulse on it (N s, N m s): along two
// tangents at the centre of the contact, and about its normal.
template <typename Real>
struct InPlane {
  Real x{}, y{}, turn{};

  InPlane operator+(const InPlane& b) const { return {x + b.x, y + b.y, turn + b.turn}; }
  InPlane operator-(const InPlane& b) const { return {x - b.x, y - b.y, turn - b.turn}; }
};

// Symmetric map between motions and impulses.
template <typename Real>
struct InPlaneMap {
  Real xx{}, xy{}, xt{}, yy{}, yt{}, tt{};

  InPlane<Real> operator*(const InPlane<Real>& a) const {
    return {xx * a.x + xy * a.y + xt * a.turn, xy * a.x + yy * a.y + yt * a.turn,
            xt * a.x + yt * a.y + tt * a.turn};
  }
  InPlaneMap inverse() const;  // zero if it has none
};

// The friction of each point is at most its coefficient times its normal impulse, and opposes its slip.
template <typename Real>
class ContactFriction {
 public:
  struct Point {
    Real x_m{}, y_m{};  // from the centre, along the tangents
    Real friction{};    // coefficient; 0 for a point that the contact does not have
    Real x_n_s{}, y_n_s{};
  };
  std::array<Point, kMaxManifoldPoints> points;
  // The impulse that the bodies have: the sum over the points, or that of a warm start.
  InPlane<Real> impulse;

  void set_response(const InPlaneMap<Real>& response);  // of the motion to impulses
  void clear();                                         // the impulses
  // One sweep. `pressed_n_s`: normal impulses of the first `count` points. `slip`: the present motion.
  // Returns the change of the impulse.
  InPlane<Real> solve(int count, const std::array<Real, kMaxManifoldPoints>& pressed_n_s,
                      const InPlane<Real>& slip);

 private:
  using Limits = std::array<Real, kMaxManifoldPoints>;
  void slide(int count, const Limits& limits_n_s, const InPlane<Real>& free_slip);
  InPlane<Real> sum(int count) const;

  InPlaneMap<Real> response_, mass_;
};

template <typename Real>
InPlaneMap<Real> InPlaneMap<Real>::inverse() const {
  const InPlaneMap adjugate{yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy,
                            xx * tt - xt * xt, xy * xt - xx * yt, xx * yy - xy * xy};
  const Real determinant = xx * adjugate.xx + xy * adjugate.xy + xt * adjugate.xt;
  const Real s = determinant > 0.0 ? 1.0 / determinant : Real{};
  return {s * adjugate.xx, s * adjugate.xy, s * adjugate.xt,
          s * adjugate.yy, s * adjugate.yt, s * adjugate.tt};
}

template <typename Real>
void ContactFriction<Real>::set_response(const InPlaneMap<Real>& response) {
  response_ = response;
  mass_ = response.inverse();
}

template <typename Real>
void ContactFriction<Real>::clear() {
  for (Point& point : points) point.x_n_s = point.y_n_s = Real{};
  impulse = {};
}

template <typename Real>
InPlane<Real> ContactFriction<Real>::sum(int count) const {
  InPlane<Real> total;
  for (int i = 0; i < count; ++i) {
    const Point& point = points[static_cast<size_t>(i)];
    total =
        total + InPlane<Real>{point.x_n_s, point.y_n_s, point.x_m * point.y_n_s - point.y_m * point.x_n_s};
  }
  return total;
}

// First the impulse that stops the slip, shared by the points in proportion to their limits: the share of a
// point is its limit times a rigid velocity field. If one exceeds its limit, or the points cannot twist, each
// point in turn.
template <typename Real>
InPlane<Real> ContactFriction<Real>::solve(int count, const std::array<Real, kMaxManifoldPoints>& pressed_n_s,
                                           const InPlane<Real>& slip) {
  Limits limits_n_s;
  Real limit{}, moment_x{}, moment_y{}, square{};
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<size_t>(i);
    const Point& point = points[at];
    limits_n_s[at] = point.friction * pressed_n_s[at];
    limit += limits_n_s[at];
    moment_x += limits_n_s[at] * point.x_m;
    moment_y += limits_n_s[at] * point.y_m;
    square += limits_n_s[at] * (point.x_m * point.x_m + point.y_m * point.y_m);
  }
  const InPlane<Real> before = impulse;
  if (FrictionMath<Real>::every(limit <= 0.0)) {
    clear();
    return impulse - before;
  }
  const Real each = limit > 0.0 ? 1.0 / limit : Real{};
  const Real centre_x = each * moment_x, centre_y = each * moment_y;
  const Real spread = square - centre_x * moment_x - centre_y * moment_y;
  // Points that are closer to their centre, relative to the centre of the contact, count as one: the share of
  // a twist would be lost in rounding.
  const auto twists = spread > 1e-9 * square;
  const InPlane<Real> wanted = impulse - mass_ * slip;
  const Real about_centre = wanted.turn - centre_x * wanted.y + centre_y * wanted.x;
  const Real turn = twists ? about_centre / spread : Real{};
  std::array<Real, kMaxManifoldPoints> share_x, share_y;
  auto sticks = limit > 0.0 ? twists : limit <= 0.0;  // without load nothing is lacking
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<size_t>(i);
    share_x[at] = each * wanted.x - turn * (points[at].y_m - centre_y);
    share_y[at] = each * wanted.y + turn * (points[at].x_m - centre_x);
    const auto within = share_x[at] * share_x[at] + share_y[at] * share_y[at] <= 1.0;
    sticks = sticks & (limits_n_s[at] > 0.0 ? within : limits_n_s[at] <= 0.0);
  }
  if (!FrictionMath<Real>::every(sticks)) slide(count, limits_n_s, slip - response_ * impulse);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<size_t>(i);
    points[at].x_n_s = sticks ? limits_n_s[at] * share_x[at] : points[at].x_n_s;
    points[at].y_n_s = sticks ? limits_n_s[at] * share_y[at] : points[at].y_n_s;
  }
  impulse = sum(count);
  return impulse - before;
}

// One sweep of projected steps over the points (a scalar step, so that friction opposes the slip exactly
// where the limit holds). `free_slip`: without friction.
template <typename Real>
void ContactFriction<Real>::slide(int count, const Limits& limits_n_s, const InPlane<Real>& free_slip) {
  const auto limited = [](Point& point, const Real& x, const Real& y, const Real& limit_n_s) {
    const Real square = x * x + y * y;
    const Real part =
        square > limit_n_s * limit_n_s ? limit_n_s / FrictionMath<Real>::root(square) : Real{} + 1.0;
    point.x_n_s = part * x;
    point.y_n_s = part * y;
  };
  for (int i = 0; i < count; ++i) {
    Point& point = points[static_cast<size_t>(i)];
    limited(point, point.x_n_s, point.y_n_s, limits_n_s[static_cast<size_t>(i)]);
  }
  InPlane<Real> slip = free_slip + response_ * sum(count);
  for (int i = 0; i < count; ++i) {
    Point& point = points[static_cast<size_t>(i)];
    const Real &x_m = point.x_m, &y_m = point.y_m, &limit_n_s = limits_n_s[static_cast<size_t>(i)];
    if (FrictionMath<Real>::every(limit_n_s <= 0.0)) continue;
    const Real slip_x = slip.x - slip.turn * y_m, slip_y = slip.y + slip.turn * x_m;
    // Response of the slip at the point to an impulse there.
    const Real xx = response_.xx - y_m * (2.0 * response_.xt - y_m * response_.tt);
    const Real yy = response_.yy + x_m * (2.0 * response_.yt + x_m * response_.tt);
    const Real xy = response_.xy + x_m * response_.xt - y_m * response_.yt - x_m * y_m * response_.tt;
    const Real determinant = xx * yy - xy * xy;
    const Real each = determinant > 0.0 ? 1.0 / determinant : Real{};
    const Real stop_x = point.x_n_s - each * (yy * slip_x - xy * slip_y);
    const Real stop_y = point.y_n_s - each * (xx * slip_y - xy * slip_x);
    const auto stops = stop_x * stop_x + stop_y * stop_y <= limit_n_s * limit_n_s;
    const Real largest = (xx > yy ? xx : yy) + FrictionMath<Real>::size(xy);  // of the eigenvalues, a bound
    const Real step = largest > 0.0 ? 1.0 / largest : Real{};
    const Real before_x = point.x_n_s, before_y = point.y_n_s;
    limited(point, stops ? stop_x : before_x - step * slip_x, stops ? stop_y : before_y - step * slip_y,
            limit_n_s);
    const Real x = point.x_n_s - before_x, y = point.y_n_s - before_y;
    slip = slip + response_ * InPlane<Real>{x, y, x_m * y - y_m * x};
  }
}

}  // namespace livegs
