// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/division/divide_by_looks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "analysis/division/place_parts.h"
#include "core/text/format_text.h"

// One border along one axis: slices across the axis have a mean colour, a width and a thickness. The border
// is where two constants explain most of the variance of the slices (Fisher 1958; Otsu 1979). The colours of
// the two sides then decide about single kernels near and beyond the border.

namespace livegs {
namespace {

constexpr int kSlices = 64;
// One unit of difference: the colours of one material vary by about 12 in CIE Lab under baked light, and
// widths of one part by a third.
constexpr double kColourUnit = 12, kWidthUnit = 0.35;
// Least share of the variance between slices that the border explains, and least difference of the two sides
// in units. Larger: more objects count as one part. Smaller: shading or a taper is taken for a border.
constexpr double kMinExplained = 0.45, kMinContrast = 2.0;
// Least ratio of the widths (thicknesses) that identifies the wide (thin) end.
constexpr double kMinWidthRatio = 1.25;
// Least share of the surface on each side: less is a cap or a stray.
constexpr double kMinSideShare = 0.03;
// Length over the second extent, as standard deviations, from which an object has a long axis.
constexpr double kMinElongation = 1.8;
// Most that the colour and the distance of a kernel count, in nats. Colour prevails far from the border only
// if it is almost certain.
constexpr double kMaxColourNats = 6, kMaxDistanceNats = 5;
constexpr double kBorderWidth = 0.02;  // distance that counts one nat, as a fraction of the length

Eigen::Vector3d lab_of(const Eigen::Vector3f& rgb) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const double r = linear(rgb.x()), g = linear(rgb.y()), b = linear(rgb.z());
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505),
               y = f(0.2126 * r + 0.7152 * g + 0.0722 * b),
               z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

using LooksVector = Eigen::Matrix<double, 5, 1>;  // L, a, b, ln width, ln thickness, in units

struct LooksSlice {
  double weight = 0;
  LooksVector looks = LooksVector::Zero();
};

struct LooksBorder {
  int slice = 0;  // the first slice of the far side
  double explained = 0;
  LooksVector difference = LooksVector::Zero();  // far minus near side
};

// The kernels along an axis, from 0 to 1 between the outermost 0.2 % of the weight.
struct AxisPlaces {
  Eigen::Vector3d axis, across, other;
  double low_m = 0, length_m = 0;
  double at(const Eigen::Vector3f& point) const {
    return (axis.dot(point.cast<double>()) - low_m) / length_m;
  }
};

std::optional<AxisPlaces> places_along(const SurfaceKernels& kernels, const Eigen::Vector3d& axis,
                                       const Eigen::Vector3d& across) {
  AxisPlaces places{axis, across, axis.cross(across)};
  std::vector<std::pair<double, double>> sorted;
  double sum = 0;
  for (size_t i = 0; i < kernels.positions_m.size(); ++i) {
    sorted.emplace_back(axis.dot(kernels.positions_m[i].cast<double>()), kernels.weights[i]);
    sum += kernels.weights[i];
  }
  if (!(sum > 0)) return std::nullopt;
  std::sort(sorted.begin(), sorted.end());
  constexpr double kStray = 0.002;
  double reached = 0, low = sorted.front().first, high = sorted.back().first;
  for (const auto& [place, weight] : sorted) {
    if (reached < kStray * sum) low = place;
    reached += weight;
    if (reached <= (1 - kStray) * sum) high = place;
  }
  places.low_m = low;
  places.length_m = high - low;
  if (!(places.length_m > 0)) return std::nullopt;
  return places;
}

std::vector<LooksSlice> slices_of(const SurfaceKernels& kernels, const std::vector<Eigen::Vector3d>& lab,
                                  const AxisPlaces& places) {
  struct Sums {
    double weight = 0;
    Eigen::Vector3d lab = Eigen::Vector3d::Zero();
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  };
  std::vector<Sums> sums(kSlices);
  for (size_t i = 0; i < lab.size(); ++i) {
    const double at = places.at(kernels.positions_m[i]);
    if (!(at >= 0 && at <= 1)) continue;
    Sums& slice = sums[static_cast<size_t>(std::min(kSlices - 1, static_cast<int>(at * kSlices)))];
    const double weight = kernels.weights[i];
    const Eigen::Vector3d point = kernels.positions_m[i].cast<double>();
    const Eigen::Vector2d across(places.across.dot(point), places.other.dot(point));
    slice.weight += weight;
    slice.lab += weight * lab[i];
    slice.mean += weight * across;
    slice.squares += weight * across * across.transpose();
  }
  std::vector<LooksSlice> slices(kSlices);
  for (size_t i = 0; i < sums.size(); ++i) {
    const Sums& sum = sums[i];
    if (!(sum.weight > 0)) continue;
    const Eigen::Vector2d mean = sum.mean / sum.weight;
    const Eigen::Matrix2d spread = sum.squares / sum.weight - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
    axes.computeDirect(spread, Eigen::EigenvaluesOnly);
    const Eigen::Vector2d widths = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
    // A thousandth of the length is below any width that matters.
    const double least = 1e-3 * places.length_m;
    slices[i].weight = sum.weight;
    slices[i].looks << sum.lab / (sum.weight * kColourUnit),
        std::log(std::max(widths.y(), least)) / kWidthUnit,
        std::log(std::max(widths.x(), least)) / kWidthUnit;
  }
  return slices;
}

LooksBorder find_border(const std::vector<LooksSlice>& slices, const LooksVector& counts) {
  double weight = 0;
  LooksVector sum = LooksVector::Zero();
  for (const LooksSlice& slice : slices) {
    weight += slice.weight;
    sum += slice.weight * slice.looks;
  }
  const LooksVector mean = sum / weight;
  double total = 0;
  for (const LooksSlice& slice : slices)
    total += slice.weight * (slice.looks - mean).cwiseProduct(counts).squaredNorm();
  LooksBorder best;
  double near_weight = 0;
  LooksVector near_sum = LooksVector::Zero();
  for (int i = 1; i < kSlices; ++i) {
    near_weight += slices[static_cast<size_t>(i - 1)].weight;
    near_sum += slices[static_cast<size_t>(i - 1)].weight * slices[static_cast<size_t>(i - 1)].looks;
    const double far_weight = weight - near_weight;
    if (near_weight < kMinSideShare * weight || far_weight < kMinSideShare * weight) continue;
    const LooksVector difference = (sum - near_sum) / far_weight - near_sum / near_weight;
    const double explained =
        near_weight * far_weight / weight * difference.cwiseProduct(counts).squaredNorm();
    if (!(total > 0) || explained / total <= best.explained) continue;
    best = {i, explained / total, difference};
  }
  return best;
}

// Colours of one side of the border.
struct SideColours {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  double log_volume = 0;  // ln of the root of the determinant
  double nats(const Eigen::Vector3d& lab) const {
    const Eigen::Vector3d from = lab - mean;
    return -0.5 * from.dot(inverse * from) - log_volume;
  }
};

SideColours colours_of_side(const SurfaceKernels& kernels, const std::vector<Eigen::Vector3d>& lab,
                            const AxisPlaces& places, double border, bool far) {
  double weight = 0;
  SideColours side;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < lab.size(); ++i) {
    if ((places.at(kernels.positions_m[i]) >= border) != far) continue;
    weight += kernels.weights[i];
    side.mean += kernels.weights[i] * lab[i];
    squares += kernels.weights[i] * lab[i] * lab[i].transpose();
  }
  side.mean /= weight;
  // The floor keeps an evenly painted part from refusing its own shaded kernels.
  const Eigen::Matrix3d spread = squares / weight - side.mean * side.mean.transpose() +
                                 0.25 * kColourUnit * kColourUnit * Eigen::Matrix3d::Identity();
  side.inverse = spread.inverse();
  side.log_volume = 0.5 * std::log(spread.determinant());
  return side;
}

struct PlacedPair {
  size_t part = 0, other = 0;  // of which `part` has the place
  PartPlace place = PartPlace::Unknown;
  std::vector<std::optional<PartHolder>> holder;
};

// The two parts with a border between them: one with a place, and the other or the rest.
std::optional<PlacedPair> pair_of(std::span<const ObjectPart> usual) {
  PlacedPair pair;
  std::vector<size_t> outer;
  for (size_t i = 0; i < usual.size(); ++i) {
    const bool filling = usual[i].place == PartPlace::Filling;
    const bool inside = i > 0 && (filling || usual[i].place == PartPlace::Inside);
    pair.holder.push_back(inside ? std::optional(PartHolder{0, filling}) : std::nullopt);
    if (!inside) outer.push_back(i);
  }
  if (outer.size() != 2) return std::nullopt;
  for (const size_t i : outer) {
    const PartPlace place = usual[i].place;
    if (place == PartPlace::Unknown) return std::nullopt;
    if (place == PartPlace::Rest || (place == PartPlace::Above && pair.place != PartPlace::Unknown)) continue;
    if (pair.place != PartPlace::Unknown && place != PartPlace::Below) return std::nullopt;
    pair.place = place;
    pair.part = i;
  }
  if (pair.place == PartPlace::Unknown) return std::nullopt;
  pair.other = pair.part == outer[0] ? outer[1] : outer[0];
  return pair;
}

}  // namespace

LooksDivision divide_by_looks(std::span<const ObjectPart> usual, const SurfaceKernels& kernels,
                              MaterialParts& parts) {
  const auto one_part = [](std::string why) { return LooksDivision{false, "one part: " + std::move(why)}; };
  const auto pair = pair_of(usual);
  if (!pair) return one_part("the parts of such things have no usual place");
  const bool vertical = pair->place == PartPlace::Above || pair->place == PartPlace::Below;
  double weight = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < kernels.positions_m.size(); ++i) {
    const Eigen::Vector3d point = kernels.positions_m[i].cast<double>();
    weight += kernels.weights[i];
    mean += kernels.weights[i] * point;
    squares += kernels.weights[i] * point * point.transpose();
  }
  if (!(weight > 0)) return one_part("no kernel is opaque");
  mean /= weight;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squares / weight - mean * mean.transpose());
  if (!vertical &&
      axes.eigenvalues()[2] < kMinElongation * kMinElongation * std::max(0.0, axes.eigenvalues()[1]))
    return one_part("it has no long axis");
  const auto places = vertical
                          ? places_along(kernels, Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX())
                          : places_along(kernels, axes.eigenvectors().col(2), axes.eigenvectors().col(1));
  if (!places) return one_part("it has no length");
  std::vector<Eigen::Vector3d> lab;
  for (const Eigen::Vector3f& rgb : kernels.rgb) lab.push_back(lab_of(rgb));
  // Leaves, shades and bases have all widths; an upright thing is divided by colour first.
  LooksVector counts = LooksVector::Ones();
  if (vertical) counts.tail<2>().setConstant(0.5);
  const LooksBorder border = find_border(slices_of(kernels, lab, *places), counts);
  const double contrast = border.difference.norm();
  if (border.explained < kMinExplained || contrast < kMinContrast) {
    return one_part(
        format_text("no clear border of colour or width; the best explains %.0f %% of the "
                    "differences, with a contrast of %.1f (at least %.0f %% and %.1f)",
                    100 * border.explained, contrast, 100 * kMinExplained, kMinContrast));
  }
  // Whether the placed part is on the far side: above, wider, or thinner.
  bool far = pair->place == PartPlace::Above;
  if (!vertical) {
    const double ratio_ln =
        kWidthUnit * (pair->place == PartPlace::Wide ? border.difference[3] : -border.difference[4]);
    if (std::abs(ratio_ln) < std::log(kMinWidthRatio)) {
      return one_part(
          format_text("both ends are equally %s", pair->place == PartPlace::Wide ? "wide" : "thick"));
    }
    far = ratio_ln > 0;
  }
  const double at = static_cast<double>(border.slice) / kSlices;
  const SideColours near_colours = colours_of_side(kernels, lab, *places, at, false),
                    far_colours = colours_of_side(kernels, lab, *places, at, true);
  std::vector<uint8_t> labels;
  for (size_t i = 0; i < lab.size(); ++i) {
    const double colour =
        std::clamp(far_colours.nats(lab[i]) - near_colours.nats(lab[i]), -kMaxColourNats, kMaxColourNats);
    const double distance = std::clamp((places->at(kernels.positions_m[i]) - at) / kBorderWidth,
                                       -kMaxDistanceNats, kMaxDistanceNats);
    labels.push_back(static_cast<uint8_t>((colour + distance > 0) == far ? pair->part : pair->other));
  }
  place_parts(kernels, labels, pair->holder, parts);
  if (!PartPlaces(parts).divided()) return one_part("no box separates its parts");
  return {true, format_text("%s and %s differ at %.0f %% of the %s: %.0f in colour (CIE Lab), %.2g times in "
                            "width; the border explains %.0f %% of the differences",
                            usual[pair->part].name.c_str(), usual[pair->other].name.c_str(), 100 * at,
                            vertical ? "height" : "length", kColourUnit * border.difference.head<3>().norm(),
                            std::exp(kWidthUnit * std::abs(border.difference[3])), 100 * border.explained)};
}

}  // namespace livegs
