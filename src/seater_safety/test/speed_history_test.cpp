#include "seater_safety/speed_history.h"

#include <gtest/gtest.h>

namespace seater_safety {
namespace {

TEST(SpeedHistoryTest, WithoutAnyTheSpeedIsZero) {
  const SpeedHistory history(1.0);
  EXPECT_EQ(history.at(5.0).linear, 0.0);
  EXPECT_EQ(history.range(0.0, &Velocity::linear).most, 0.0);
  EXPECT_FALSE(history.reaches(5.0));
}

TEST(SpeedHistoryTest, EachIsInForceUntilTheNext) {
  SpeedHistory history(1.0);
  history.add(10.0, {0.1, 0.0});
  history.add(10.5, {0.3, -0.2});
  EXPECT_EQ(history.at(9.9).linear, 0.0);
  EXPECT_EQ(history.at(10.0).linear, 0.1);
  EXPECT_EQ(history.at(10.49).linear, 0.1);
  EXPECT_EQ(history.at(20.0).linear, 0.3);
  EXPECT_TRUE(history.reaches(10.0));
  EXPECT_FALSE(history.reaches(9.99));
}

TEST(SpeedHistoryTest, ARangeBeginsWithWhatWasInForceThen) {
  SpeedHistory history(10.0);
  double time = 100.0;
  for (const double v : {0.5, 0.1, 0.2, 0.3}) history.add(time++, {v, -v});
  const auto range = history.range(101.5, &Velocity::linear);
  EXPECT_EQ(range.least, 0.1) << "sent at 101, in force until 102";
  EXPECT_EQ(range.most, 0.3);
  EXPECT_EQ(history.range(102.0, &Velocity::angular).most, -0.2);
}

TEST(SpeedHistoryTest, WhatIsOutOfForceForLongerThanTheSpanIsForgotten) {
  SpeedHistory history(1.0);
  history.add(10.0, {0.5, 0.0});
  history.add(10.5, {0.1, 0.0});
  history.add(11.4, {0.1, 0.0});
  EXPECT_TRUE(history.reaches(10.0)) << "in force until 10.5, 0.9 s ago";
  history.add(11.5, {0.1, 0.0});
  EXPECT_FALSE(history.reaches(10.4));
  EXPECT_TRUE(history.reaches(10.5));
}

}  // namespace
}  // namespace seater_safety
