// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/division/label_boxes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace livegs {
namespace {

// Leaves of the tree. More follow noise of single kernels; fewer do not follow a slanted or curved part.
constexpr size_t kMaxLeaves = 12;
// Least fraction of the whole impurity that a cut removes. Larger: fewer boxes.
constexpr double kMinGain = 0.01;
constexpr int kCutBins = 64;  // candidate cuts along each side of a leaf, 65 with both ends
// Margin around the points of a box, a fraction of the diagonal of all: the surface of the body is not at
// kernel centres. Larger: boxes include more of their neighbours.
constexpr double kBoxMargin = 0.03;

// Share of the weight of a box or part beyond its bounds on each side: stray kernels.
constexpr double kStrayShare = 0.02;

using LabelWeights = std::vector<double>;

double impurity(const LabelWeights& weights) {  // Gini, times the weight
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!(sum > 0)) return 0;
  double squares = 0;
  for (const double one : weights) squares += one * one;
  return sum - squares / sum;
}

struct BoxTreeNode {
  Eigen::AlignedBox3d box;
  std::vector<uint32_t> points;
  LabelWeights weights;
  int axis = -1;  // of its best cut; -1: none
  double cut_m = 0, gain = 0;
  int low = -1, high = -1;  // children; -1: a leaf

  size_t label() const {
    return static_cast<size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  }
};

void find_cut(const LabelledPoints& points, BoxTreeNode& node) {
  const double whole = impurity(node.weights);
  if (!(whole > 0)) return;
  const size_t labels = node.weights.size();
  for (int axis = 0; axis < 3; ++axis) {
    float low = INFINITY, high = -INFINITY;
    for (const uint32_t i : node.points) {
      low = std::min(low, points.positions_m[i][axis]);
      high = std::max(high, points.positions_m[i][axis]);
    }
    if (!(high > low)) continue;
    std::vector<double> bins(kCutBins * labels, 0.0);
    const double per_bin = (static_cast<double>(high) - low) / kCutBins;
    for (const uint32_t i : node.points) {
      const int bin = std::min(kCutBins - 1, static_cast<int>((points.positions_m[i][axis] - low) / per_bin));
      bins[static_cast<size_t>(bin) * labels + points.labels[i]] += points.weights[i];
    }
    LabelWeights below(labels, 0.0), above = node.weights;
    for (int bin = 0; bin + 1 < kCutBins; ++bin) {
      for (size_t label = 0; label < labels; ++label) {
        below[label] += bins[static_cast<size_t>(bin) * labels + label];
        above[label] = node.weights[label] - below[label];
      }
      const double gain = whole - impurity(below) - impurity(above);
      if (gain <= node.gain) continue;
      node.gain = gain;
      node.axis = axis;
      node.cut_m = low + (bin + 1) * per_bin;
    }
  }
}

}  // namespace

Eigen::AlignedBox3d bounds_without_strays(const LabelledPoints& points, std::span<const uint32_t> chosen) {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::pair<float, float>> places;
    double whole = 0, reached = 0;
    for (const uint32_t i : chosen) {
      if (!(points.weights[i] > 0)) continue;
      places.emplace_back(points.positions_m[i][axis], points.weights[i]);
      whole += points.weights[i];
    }
    if (places.empty()) return {};
    std::sort(places.begin(), places.end());
    low[axis] = places.front().first;
    high[axis] = places.back().first;
    for (const auto& [place, weight] : places) {
      if (reached <= kStrayShare * whole) low[axis] = place;
      reached += weight;
      if (reached <= (1 - kStrayShare) * whole) high[axis] = place;
    }
    high[axis] = std::max(low[axis], high[axis]);
  }
  return {low, high};
}

namespace {

class BoxTree {
 public:
  BoxTree(const LabelledPoints& points, size_t labels) : points_(points), labels_(labels) {
    BoxTreeNode root;
    for (uint32_t i = 0; i < points.labels.size(); ++i) {
      if (points.labels[i] >= labels) continue;
      root.points.push_back(i);
      root.box.extend(points.positions_m[i].cast<double>());
    }
    if (root.points.empty()) return;
    margin_m_ = Eigen::Vector3d::Constant(kBoxMargin * root.box.diagonal().norm());
    root.box = {root.box.min() - margin_m_, root.box.max() + margin_m_};
    weigh(root);
    find_cut(points_, root);
    const double least = kMinGain * impurity(root.weights);
    nodes_.push_back(std::move(root));
    for (size_t leaves = 1; leaves < kMaxLeaves; ++leaves) {
      size_t best = nodes_.size();
      for (size_t i = 0; i < nodes_.size(); ++i) {
        if (nodes_[i].low >= 0 || nodes_[i].axis < 0 || nodes_[i].gain < least) continue;
        if (best == nodes_.size() || nodes_[i].gain > nodes_[best].gain) best = i;
      }
      if (best == nodes_.size()) break;
      cut(best);
    }
    if (!nodes_.empty()) merge(0);
  }

  std::vector<std::vector<Eigen::AlignedBox3d>> boxes() const {
    std::vector<std::vector<Eigen::AlignedBox3d>> boxes(labels_);
    if (!nodes_.empty()) collect(0, boxes);
    return boxes;
  }

 private:
  void weigh(BoxTreeNode& node) const {
    node.weights.assign(labels_, 0.0);
    for (const uint32_t i : node.points) node.weights[points_.labels[i]] += points_.weights[i];
  }
  void cut(size_t parent) {
    BoxTreeNode low, high;
    const int axis = nodes_[parent].axis;
    const double cut_m = nodes_[parent].cut_m;
    low.box = high.box = nodes_[parent].box;
    low.box.max()[axis] = high.box.min()[axis] = cut_m;
    for (const uint32_t i : nodes_[parent].points)
      (points_.positions_m[i][axis] < cut_m ? low : high).points.push_back(i);
    for (BoxTreeNode* child : {&low, &high}) {
      weigh(*child);
      find_cut(points_, *child);
    }
    nodes_[parent].low = static_cast<int>(nodes_.size());
    nodes_[parent].high = nodes_[parent].low + 1;
    nodes_.push_back(std::move(low));
    nodes_.push_back(std::move(high));
  }
  // Joins leaves of one label that a cut separated in vain. Returns whether the node is a leaf now.
  bool merge(size_t at) {
    if (nodes_[at].low < 0) return true;
    const size_t low = static_cast<size_t>(nodes_[at].low), high = static_cast<size_t>(nodes_[at].high);
    const bool low_leaf = merge(low), high_leaf = merge(high);
    if (!low_leaf || !high_leaf || nodes_[low].label() != nodes_[high].label()) return false;
    nodes_[at].low = nodes_[at].high = -1;
    return true;
  }
  void collect(size_t at, std::vector<std::vector<Eigen::AlignedBox3d>>& boxes) const {
    const BoxTreeNode& node = nodes_[at];
    if (node.low < 0) {
      // Only as far as its own points reach. Points outside, such as leaves next to a pot, belong to the
      // rest.
      std::vector<uint32_t> own_points;
      for (const uint32_t i : node.points) {
        if (points_.labels[i] == node.label()) own_points.push_back(i);
      }
      Eigen::AlignedBox3d own = bounds_without_strays(points_, own_points);
      own = {own.min() - margin_m_, own.max() + margin_m_};
      boxes[node.label()].push_back(own.intersection(node.box));
      return;
    }
    collect(static_cast<size_t>(node.low), boxes);
    collect(static_cast<size_t>(node.high), boxes);
  }

  const LabelledPoints& points_;
  size_t labels_;
  Eigen::Vector3d margin_m_ = Eigen::Vector3d::Zero();
  std::vector<BoxTreeNode> nodes_;
};

}  // namespace

std::vector<std::vector<Eigen::AlignedBox3d>> label_boxes(const LabelledPoints& points, size_t label_count) {
  auto boxes = BoxTree(points, label_count).boxes();
  const auto extent = [](const std::vector<Eigen::AlignedBox3d>& of) {
    double volume_m3 = 0;
    for (const Eigen::AlignedBox3d& box : of) volume_m3 += box.volume();
    return std::pair(of.size(), volume_m3);
  };
  const auto most = std::max_element(boxes.begin(), boxes.end(),
                                     [&](const auto& a, const auto& b) { return extent(a) < extent(b); });
  if (most != boxes.end()) most->clear();
  return boxes;
}

}  // namespace livegs
