// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/prior_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/estimate/class_mass.h"
#include "analysis/estimate/object_classes.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/estimate/stiffness_classes.h"
#include "analysis/gate/fuse_answer.h"
#include "analysis/gate/mass_bounds.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::Physics;

// A part below this share of the mass does not carry the object.
constexpr double kMinStructuralShare = 0.05;
// Quantile of a standard normal at the ends of a range of 90 %.
constexpr double kRangeEnd = 1.645;

// Log-normal estimate whose range of 90 % need not be symmetric.
struct Spread {
  double best_ln = 0, below_sd = 0, above_sd = 0;
};

// Precondition: 0 < low <= best <= high.
Spread spread_of(const Span3& span) {
  return {std::log(span.best), std::log(span.best / span.low) / kRangeEnd,
          std::log(span.high / span.best) / kRangeEnd};
}

// Spread of a product of independent factors.
Spread product(const Spread& a, const Spread& b) {
  return {a.best_ln + b.best_ln, std::hypot(a.below_sd, b.below_sd), std::hypot(a.above_sd, b.above_sd)};
}

// The density at `value_ln` over that at the best value, 0 to 1. `own_sd`: error of the value itself.
double likelihood_ratio(double value_ln, const Spread& prior, double own_sd) {
  const double off = value_ln - prior.best_ln;
  const double sd = std::hypot(off < 0 ? prior.below_sd : prior.above_sd, own_sd);
  return off == 0 ? 1 : std::exp(-0.5 * off * off / (sd * sd));
}

// The one threshold. An estimate of the tables is of an unusual thing with the probability kBroadShare. A
// value whose likelihood ratio is below it is explained better by an unusual thing, or by a wrong answer,
// than by the estimate: a person decides. 0.02 is 2.8 standard deviations, or a range of 90 % extended by 0.7
// of its halves. Larger: more right answers are held.
bool unlikely(double ratio) { return ratio < kBroadShare; }

// E* = s E of a class that the name may mean, and whether such a body is rigid.
struct StiffnessPrior {
  Spread spread;
  bool rigid = false;
};

StiffnessPrior stiffness_prior(const Span3& structure, const Span3& youngs_pa, const MaterialRow* material) {
  StiffnessPrior prior{product(spread_of(structure), spread_of(youngs_pa))};
  const bool soft = material && is_soft_class(material->material_class);
  prior.rigid = prior.spread.best_ln > std::log(soft ? kRigidStiffness_pa : kStiffStiffness_pa);
  return prior;
}

// All stiffnesses of a rigid body are the same to the eye: those above its best one, or above
// kRigidStiffness_pa if that is less, count as that.
double likelihood_ratio(double stiffness_ln, StiffnessPrior prior, double own_sd) {
  if (prior.rigid) {
    prior.spread.best_ln = std::min(prior.spread.best_ln, std::log(kRigidStiffness_pa));
    stiffness_ln = std::min(stiffness_ln, prior.spread.best_ln);
  }
  return likelihood_ratio(stiffness_ln, prior.spread, own_sd);
}

bool means(const ObjectRow& name, const ObjectRow& thing) {
  return &name == &thing || std::any_of(name.alternatives.begin(), name.alternatives.end(),
                                        [&](const auto& other) { return other.label == thing.label; });
}

// One prior for each class that the name may mean, that of the current values first; empty if the name says
// neither a class nor a material. The pictures decide the class, so its probability does not count.
std::vector<StiffnessPrior> stiffness_priors(const ObjectFacts& facts,
                                             const v1::PhysicalParameters& offline) {
  const ObjectClasses found = object_classes(facts);
  const bool named = is_named(found);
  std::vector<StiffnessPrior> priors;
  if (!named && !found.material.row) return priors;
  const Span3 structure = span_of(offline.structure_coefficient()),
              youngs_pa = span_of(offline.youngs_modulus_pa());
  if (structure.low > 0 && youngs_pa.low > 0)
    priors.push_back(stiffness_prior(structure, youngs_pa, find_material_row(offline.material())));
  if (!named) return priors;
  for (const ObjectClass& kind : found.kinds) {
    if (found.kinds.size() > 1 && !means(*found.match.row, *kind.row)) continue;  // added by appearance
    const MaterialRow& material = kind.material ? *kind.material : material_row(kind.row->material);
    priors.push_back(stiffness_prior(kind.row->structure_coefficient, material.youngs_modulus_pa, &material));
  }
  return priors;
}

// A rigid object needs a rigid structural part; a small stoneware part in foam is not structural.
std::string rigid_at_odds(const Answer& answer, const v1::PhysicalParameters& proposal) {
  if (proposal.behavior() != Physics::RIGID) return "";
  double young = 0;
  if (is_locked(proposal.youngs_modulus_pa())) {
    young = proposal.youngs_modulus_pa().best();
  } else if (answer.youngs_modulus_pa) {
    young = answer.youngs_modulus_pa->best;
  } else {
    for (const AnswerPart& part : answer.parts) {
      if (&part == &answer.parts.front() || part.share >= kMinStructuralShare)
        young = std::max(young, part.material->youngs_modulus_pa.best);
    }
  }
  const double stiffness = young * (answer.structure_coefficient ? answer.structure_coefficient->best : 1.0);
  if (!(stiffness < kSoftStiffness_pa)) return "";
  return format_text(
      "behaviour: rigid does not fit s E = %.3g MPa of %s, which a hand deforms (below %g MPa)",
      stiffness * 1e-6, materials_of(answer).c_str(), kSoftStiffness_pa * 1e-6);
}

// A class between the two limits of stiffness_classes.h may be called either.
std::string unlikely_behaviour(const v1::PhysicalParameters& proposal, const v1::PhysicalParameters& offline,
                               const std::vector<StiffnessPrior>& priors) {
  if (proposal.behavior() == offline.behavior()) return "";
  const bool rigid = proposal.behavior() == Physics::RIGID;
  for (const StiffnessPrior& prior : priors) {
    const double stiffness_pa = std::exp(prior.spread.best_ln);
    if (rigid ? stiffness_pa >= kSoftStiffness_pa : stiffness_pa <= kRigidStiffness_pa) return "";
  }
  return format_text("behaviour: %s, but an object called \"%s\" is %s, with s E = %.3g MPa",
                     rigid ? "rigid" : "elastic", offline.label().c_str(), rigid ? "elastic" : "rigid",
                     std::exp(priors.front().spread.best_ln) * 1e-6);
}

// Compares E* = s E, because a thin structure and a soft material are interchangeable. The structure
// coefficient of an answer is a judgement, so its range counts; its modulus is near that of its material.
std::string unlikely_stiffness(const Answer& answer, const v1::PhysicalParameters& proposal,
                               const std::vector<StiffnessPrior>& priors) {
  const EstimatedValue& young = proposal.youngs_modulus_pa();
  const EstimatedValue& structure = proposal.structure_coefficient();
  if (is_locked(young) && is_locked(structure)) return "";
  const double answered_pa =
      answer.youngs_modulus_pa && !is_locked(young) ? answer.youngs_modulus_pa->best : young.best();
  const double stiffness_pa = answered_pa * (structure.best() > 0 ? structure.best() : 1.0);
  const double own_sd = answer.structure_coefficient ? log_normal_of(*answer.structure_coefficient).sd : 0;
  for (const StiffnessPrior& prior : priors) {
    if (!unlikely(likelihood_ratio(std::log(stiffness_pa), prior, own_sd))) return "";
  }
  return format_text("%s: s E = %.3g MPa is unlikely; its kind suggests %.3g MPa",
                     answer.youngs_modulus_pa ? "young_mpa.best" : "structure_s", stiffness_pa * 1e-6,
                     std::exp(priors.front().spread.best_ln) * 1e-6);
}

// The density of a mass under all classes over the highest one, which is near the mean of a class.
double likelihood_ratio(const LogNormal& mass, const ObjectClasses& classes, const ObjectFacts& facts) {
  std::vector<WeightedLogNormal> mixture;
  for (const ObjectClass& kind : classes.kinds) {
    LogNormal one = kind_mass(kind, facts).mass;
    one.sd = std::hypot(one.sd, mass.sd);
    mixture.push_back({kind.probability, one});
  }
  double highest = 0;
  for (const WeightedLogNormal& one : mixture)
    highest = std::max(highest, mixture_density_ln(mixture, one.value.mean_ln));
  return mixture_density_ln(mixture, mass.mean_ln) / highest;
}

// Compares the mass with the classes of the object, and with those of the answer's name. If the current
// estimate is another one, because a user gave a fill or a wall, it replaces the classes of the object.
std::string unlikely_mass(const Answer& answer, const ObjectFacts& facts, const EstimatedValue& estimate) {
  const LogNormal answered = log_normal_of(answer.mass_kg);
  const ObjectClasses own = object_classes(facts);
  const bool replaced = estimate.best() != mass_of_classes(own, facts).mass_kg.best;
  const double ratio = replaced && estimate.low() > 0
                           ? likelihood_ratio(answered.mean_ln, spread_of(span_of(estimate)), answered.sd)
                           : likelihood_ratio(answered, own, facts);
  if (estimate.best() > 0 && unlikely(ratio)) {
    return format_text("mass_g.best: %.4g g is unlikely; size and kind suggest %.4g g",
                       answer.mass_kg.best * 1e3, estimate.best() * 1e3);
  }
  const ObjectClasses classes = answered_classes(answer, answer.name, facts);
  if (!is_named(classes) || !unlikely(likelihood_ratio(answered, classes, facts))) return "";
  return format_text("mass_g.best: %.4g g is unlikely; \"%s\" of this size suggests %.4g g",
                     answer.mass_kg.best * 1e3, answer.name.c_str(),
                     mass_of_classes(classes, facts).mass_kg.best * 1e3);
}

}  // namespace

std::string check_prior(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                        const v1::PhysicalParameters& proposal) {
  if (!is_locked(offline.mass_kg())) {
    if (auto why = unlikely_mass(answer, facts, offline.mass_kg()); !why.empty()) return why;
    if (auto why = mass_at_odds(answer, facts); !why.empty()) return why;
  }
  if (auto why = rigid_at_odds(answer, proposal); !why.empty()) return why;
  const std::vector<StiffnessPrior> priors = stiffness_priors(facts, offline);
  if (priors.empty()) return "";
  if (auto why = unlikely_behaviour(proposal, offline, priors); !why.empty()) return why;
  return unlikely_stiffness(answer, proposal, priors);
}

}  // namespace livegs
