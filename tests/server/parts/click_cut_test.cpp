// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/click/click_cut.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/parallel_for.h"
#include "sample/made_room.h"

namespace livegs {
namespace {

// A room with true labels; some of its things may be joined to one part.
struct ClickedRoom {
  explicit ClickedRoom(RoomKind kind)
      : room(make_room(kind, {1, 0.006, {}})),
        graph(room.asset, room.owner, -Eigen::Vector3d::UnitY()),
        label(room.owner) {}
  void join(uint16_t thing, uint16_t to) {
    std::replace(label.begin(), label.end(), thing, to);
    graph = KernelGraph(room.asset, label, -Eigen::Vector3d::UnitY());
  }
  // The kernel of a thing that is nearest to a point of its bounds, each coordinate 0 to 1; y is down.
  uint32_t kernel(uint16_t thing, const Eigen::Vector3d& at) const {
    const Eigen::AlignedBox3d& box = room.bounds_m[thing - 1];
    const Eigen::Vector3d point = box.min() + at.cwiseProduct(box.sizes());
    uint32_t best = 0;
    double least = 1e9;
    for (uint32_t k = 0; k < room.owner.size(); ++k) {
      const double distance = (room.asset.positions[k].cast<double>() - point).norm();
      if (room.owner[k] == thing && distance < least) least = distance, best = k;
    }
    return best;
  }
  double iou(const CutThing& cut, uint16_t thing) const {
    size_t both = 0, truth = 0;
    for (const uint32_t k : cut.kernels) both += room.owner[k] == thing;
    for (const uint16_t owner : room.owner) truth += owner == thing;
    return static_cast<double>(both) / static_cast<double>(truth + cut.kernels.size() - both);
  }
  MadeRoom room;
  KernelGraph graph;
  std::vector<uint16_t> label;
};

TEST(CutThing, OneClickTakesThePart) {
  const ClickedRoom clicked(RoomKind::Apart);
  const Click click{clicked.kernel(1, {0.5, 0.3, 0.5}), true};
  const CutThing cut = cut_thing(clicked.graph, clicked.label, {&click, 1});
  EXPECT_GE(clicked.iou(cut, 1), 0.98);
  EXPECT_LT(cut.nodes, clicked.label.size() / 10) << "only kernels near the border are nodes";
  const Click away{click.kernel, false};
  EXPECT_TRUE(cut_thing(clicked.graph, clicked.label, {&away, 1}).kernels.empty());
  EXPECT_TRUE(cut_thing(clicked.graph, clicked.label, {}).kernels.empty());
}

// Two things that were found as one part are divided by one click on each, up to a face or a label that has
// another light or colour than the rest of its thing.
TEST(CutThing, AClickThatTakesAwayDividesAPartOfTwoThings) {
  struct Pair {
    RoomKind kind;
    uint16_t taken, other;
  };
  for (const Pair& pair : {Pair{RoomKind::Stacked, 2, 1},
                           {RoomKind::Stacked, 1, 2},
                           {RoomKind::Touching, 1, 2},
                           {RoomKind::Touching, 6, 5},
                           {RoomKind::Touching, 3, 4},
                           {RoomKind::Stacked, 4, 3}}) {
    ClickedRoom clicked(pair.kind);
    clicked.join(pair.other, pair.taken);
    const Click clicks[] = {{clicked.kernel(pair.taken, {0.9, 0.5, 0.1}), true},
                            {clicked.kernel(pair.other, {0.9, 0.5, 0.1}), false}};
    EXPECT_LT(clicked.iou(cut_thing(clicked.graph, clicked.label, {clicks, 1}), pair.taken), 0.81);
    EXPECT_GE(clicked.iou(cut_thing(clicked.graph, clicked.label, clicks), pair.taken), 0.86)
        << clicked.room.names[pair.taken - 1] << " and " << clicked.room.names[pair.other - 1];
  }
}

// A click that takes away near the rim of a face removes at most the next face.
TEST(CutThing, AClickThatTakesAwayAtTheRimKeepsTheThing) {
  const ClickedRoom clicked(RoomKind::Stacked);
  const Click clicks[] = {{clicked.kernel(4, {0.5, 0, 0.5}), true},
                          {clicked.kernel(4, {0.1, 0, 0.5}), false}};
  const CutThing cut = cut_thing(clicked.graph, clicked.label, clicks);
  EXPECT_GE(clicked.iou(cut, 4), 0.75);
  EXPECT_FALSE(std::binary_search(cut.kernels.begin(), cut.kernels.end(), clicks[1].kernel));
}

TEST(CutThing, AClickNextToTheThingCorrectsItsBorderAndOneFarAwayJoinsAPart) {
  const ClickedRoom clicked(RoomKind::Touching);
  std::vector<Click> clicks{{clicked.kernel(1, {0.2, 0.5, 0}), true},
                            {clicked.kernel(2, {0, 0.5, 0.5}), true}};
  EXPECT_GE(clicked.iou(cut_thing(clicked.graph, clicked.label, clicks), 1), 0.95);
  clicks[1].kernel = clicked.kernel(6, {1, 0.5, 0.5});
  const CutThing both = cut_thing(clicked.graph, clicked.label, clicks);
  size_t other = 0;
  for (const uint32_t k : both.kernels) other += clicked.room.owner[k] == 6;
  EXPECT_GE(other, 95 * std::count(clicked.label.begin(), clicked.label.end(), 6) / 100);
}

TEST(CutThing, SameKernelsForAnyThreadCount) {
  std::vector<uint32_t> first;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    ClickedRoom clicked(RoomKind::Stacked);
    clicked.join(2, 1);
    const Click clicks[] = {{clicked.kernel(2, {1, 0.5, 0.5}), true}, {clicked.kernel(1, {1, 0, 0}), false}};
    const CutThing cut = cut_thing(clicked.graph, clicked.label, clicks);
    if (threads == 1) first = cut.kernels;
    EXPECT_EQ(cut.kernels, first);
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace livegs
