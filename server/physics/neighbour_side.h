// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "physics/contact_rows.h"
#include "physics/elastic_body.h"

namespace livegs {

// An elastic body that takes its step before or after this one: impulses change its velocities.
class NeighbourSide final : public ContactSide {
 public:
  NeighbourSide(ElasticBody& body, double response_s) : body_(body), response_s_(response_s) {}
  Eigen::Matrix3d response(const ContactSpot& spot) const override {
    return response_s_ * body_.spot_mobility(spot) * Eigen::Matrix3d::Identity();
  }
  Eigen::Vector3d way_m(const ContactSpot& spot) const override {
    return spot.base_m + response_s_ * body_.spot_velocity_m_s(spot);
  }
  void give(const ContactSpot& spot, const Eigen::Vector3d& point, const Eigen::Vector3d& impulse) override {
    body_.push_spot(spot, point, impulse);
  }
  void count(const ContactSpot& spot, const Eigen::Vector3d& point, const Eigen::Vector3d& impulse) override {
    body_.settle_spot(spot, point, impulse);
  }

 private:
  ElasticBody& body_;
  double response_s_;
};

}  // namespace livegs
