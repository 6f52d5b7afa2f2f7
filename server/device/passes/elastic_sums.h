// SPDX-License-Identifier: GPL-3.0-or-later

// Sums of rows, for GLSL and C++ (shader_math.h).

#ifndef LIVEGS_DEVICE_ELASTIC_SUMS_H
#define LIVEGS_DEVICE_ELASTIC_SUMS_H
#include "device/passes/elastic_layout.h"
#ifdef __cplusplus
namespace livegs::shader {
#endif

LIVEGS_SHARED_BODY NodeSumsRow no_node_sums() {
  NodeSumsRow zero;
  zero.first = zero.momentum = zero.angular = zero.before = vec4(0.0f);
  zero.squares = zero.products = zero.kicked = zero.load = vec4(0.0f);
  return zero;
}

LIVEGS_SHARED_BODY NodeSumsRow sum_of(NodeSumsRow a, NodeSumsRow b) {
  NodeSumsRow sum;
  sum.first = a.first + b.first;
  sum.momentum = a.momentum + b.momentum;
  sum.angular = a.angular + b.angular;
  sum.before = a.before + b.before;
  sum.squares = a.squares + b.squares;
  sum.products = a.products + b.products;
  sum.kicked = a.kicked + b.kicked;
  sum.load = a.load + b.load;
  return sum;
}

LIVEGS_SHARED_BODY ContactSumsRow no_contact_sums() {
  ContactSumsRow zero;
  zero.impulse = zero.moment = zero.at = zero.rolled = zero.squares = zero.products = vec4(0.0f);
  return zero;
}

LIVEGS_SHARED_BODY ContactSumsRow sum_of(ContactSumsRow a, ContactSumsRow b) {
  ContactSumsRow sum;
  sum.impulse = a.impulse + b.impulse;
  sum.moment = a.moment + b.moment;
  sum.at = a.at + b.at;
  sum.rolled = a.rolled + b.rolled;
  sum.squares = a.squares + b.squares;
  sum.products = a.products + b.products;
  return sum;
}

#ifdef __cplusplus
}  // namespace livegs::shader
#endif
#endif
