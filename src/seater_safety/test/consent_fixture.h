// A gate that is asked, waited for and stopped.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "seater_safety/velocity_gate.h"

namespace seater_safety {

inline const std::string kDocking = "/docking";
constexpr Velocity kForward{0.4, 0.2};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class ConsentTest : public testing::Test {
 protected:
  // One second of requests at 20 Hz; returns the last output.
  Velocity ask(const Velocity& velocity, double duration = 1.0, double age = 0.0) {
    Velocity output;
    for (const double end = now_ + duration; now_ < end; now_ += 0.05) {
      gate_.request(now_, kDocking, velocity, age);
      output = gate_.output(now_);
    }
    return output;
  }

  Velocity wait(double duration) {
    Velocity output;
    for (const double end = now_ + duration; now_ < end; now_ += 0.02) output = gate_.output(now_);
    return output;
  }

  bool arm(const std::string& holder = kDocking) { return !gate_.arm(now_, holder).has_value(); }

  void drive() {
    wait(1.0);
    ASSERT_TRUE(arm());
    ASSERT_GT(ask(kForward, 2.0).linear, 0.39);
  }

  // After a stop: requests go on and nothing moves; then a new goal drives again.
  void expectLatched(GateState cause) {
    EXPECT_FALSE(gate_.status(now_).motion_allowed);
    EXPECT_EQ(gate_.status(now_).stopped_by, cause);
    EXPECT_EQ(ask(kForward, 3.0).linear, 0.0);
    EXPECT_FALSE(arm()) << "the requester has not noticed the stop";
    EXPECT_EQ(ask({}, 0.5).linear, 0.0);
    EXPECT_EQ(gate_.status(now_).stopped_by, cause) << "the cause stays until a new consent";
    ASSERT_TRUE(arm());
    EXPECT_GT(ask(kForward, 2.0).linear, 0.39);
  }

  VelocityGate gate_{GateParameters{}};
  double now_ = 100.0;
};

}  // namespace seater_safety
