// SPDX-License-Identifier: Apache-2.0
#include "viewer/study/force_study.h"

#include <gtest/gtest.h>

#include "viewer/panels/frame_meter.h"

namespace livegs {
namespace {

TEST(ForceStudy, SentenceMatchesMessage) {
  ForceStudy study;
  EXPECT_FALSE(study.shown("").ready);
  study.aim({"pillow", 3, 17, {0.1, 0.2, 0.3}});
  study.choose({12, 0.5, 90, 0});
  EXPECT_EQ(study.sentence(), "Apply a force of 12 newtons to the pillow for 0.5 seconds.");
  const v1::Event::Force force = study.message();
  EXPECT_EQ(force.object(), "pillow");
  EXPECT_DOUBLE_EQ(force.point_m(1), 0.2);
  EXPECT_NEAR(force.force_n(0), 12, 1e-12);  // a quarter turn from +Z about +Y is +X
  EXPECT_NEAR(force.force_n(1), 0, 1e-12);
  EXPECT_NEAR(force.force_n(2), 0, 1e-12);
  EXPECT_DOUBLE_EQ(force.duration_s(), 0.5);
  EXPECT_TRUE(study.shown("").ready);
}

TEST(ForceStudy, SentencesUseWords) {
  const auto study = [](const std::string& object, double size_n, double duration_s) {
    ForceStudy made;
    made.aim({object, 1, 0, {0, 0, 0}});
    made.choose({size_n, duration_s, 0, 90});
    return made;
  };
  EXPECT_EQ(study("hat", 1, 1).sentence(), "Apply a force of 1 newton to the hat for 1 second.");
  EXPECT_EQ(study("hat", 1200, 0.05).sentence(),
            "Apply a force of 1200 newtons to the hat for 0.05 seconds.");
  EXPECT_EQ(study("hat", 0.001, 10).sentence(), "Apply a force of 0.001 newtons to the hat for 10 seconds.");
  const std::vector<ForceStudy> several = {study("hat", 5, 1), study("cup", 2, 0.5), study("hat", 5, 1),
                                           study("bag", 1, 3)};
  EXPECT_EQ(sentence_of(several),
            "Apply a force of 5 newtons to the hat for 1 second at 2 points, a force of 2 newtons to the "
            "cup for 0.5 seconds, and a force of 1 newton to the bag for 3 seconds.");
}

TEST(ForceStudy, ForceHasSizeAndDirection) {
  ForceStudy study;
  for (const Eigen::Vector3d& force_n : {Eigen::Vector3d(1, 2, 3), {0, -4, 0}, {-5, 0.1, -2}}) {
    study.choose_force(force_n, 1);
    EXPECT_LT((study.force_n() - force_n).norm(), 1e-12 * force_n.norm() + 1e-12);
  }
}

TEST(ForceStudy, ParsesForceOption) {
  const auto force = parse_force("a:b:0,0.1,0:0,-12,1e1:0.5");
  ASSERT_TRUE(force) << force.error().message;
  EXPECT_EQ(force->object(), "a:b");
  EXPECT_DOUBLE_EQ(force->point_m(1), 0.1);
  EXPECT_DOUBLE_EQ(force->force_n(2), 10);
  EXPECT_DOUBLE_EQ(force->duration_s(), 0.5);
  for (const char* bad :
       {"", "hat", "hat:0,0,0:1,2,3", "hat:0,0:1,2,3:1", "hat:0,0,0:1,2,3:1x", ":0,0,0:1,2,3:1", ":::"}) {
    const auto refused = parse_force(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_NE(refused.error().message.find("OBJECT:X,Y,Z:FX,FY,FZ:SECONDS"), std::string::npos);
  }
  for (const char* bad :
       {"hat:0,nan,0:1,2,3:1", "hat:0,0,0:1,inf,3:1", "hat:0,0,0:1,2,3:0", "hat:0,0,0:1,2,3:-1",
        "hat:0,0,0:1,2,3:61", "hat:0,0,0:1,2,3:nan", "hat:0,0,0:1,2,3:inf"}) {
    const auto refused = parse_force(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code, ErrorCode::InvalidArgument);
  }
  EXPECT_TRUE(parse_force("hat:0,0,0:1,2,3:60"));
}

TEST(FrameMeter, MeasuresRatesAndHandLatency) {
  FrameMeter meter;
  EXPECT_FALSE(meter.hand_to_picture_ms());
  ReceivedFrame frame;
  for (int i = 0; i <= 100; ++i) {  // 50 pictures and 90 ticks per second, each sample shown 30 ms later
    const int64_t shown_ns = 20'000'000 * int64_t{i};
    meter.sampled(static_cast<uint64_t>(i + 1), shown_ns - 30'000'000);
    frame.tick = static_cast<uint64_t>(i * 90 / 50);
    frame.input_sequence = static_cast<uint64_t>(i + 1);
    frame.received_ns = shown_ns - 5'000'000;
    frame.step_ms = 2;
    meter.shown(frame, shown_ns, 20);
  }
  EXPECT_NEAR(meter.pictures_a_second(), 50, 1e-9);
  EXPECT_NEAR(meter.ticks_a_second(), 90, 1);
  EXPECT_NEAR(*meter.hand_to_picture_ms(), 30, 1e-9);
  EXPECT_NEAR(meter.graph().age_ms.back(), 5, 1e-5);
  EXPECT_NEAR(meter.graph().picture_ms.back(), 20, 1e-5);
}

}  // namespace
}  // namespace livegs
