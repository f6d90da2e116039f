// Consent: nothing moves by a request without it, and it ends for good with every stop.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

const std::string kDocking = "/docking";
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

TEST_F(ConsentTest, RequestsWithoutItMoveNothing) {
  EXPECT_EQ(ask(kForward, 2.0).linear, 0.0);
  EXPECT_EQ(gate_.state(), GateState::kStopped);
  EXPECT_GE(gate_.ignored(), 40u);
  EXPECT_EQ(gate_.status(now_).reason, "/docking sends velocity requests without consent");
}

TEST_F(ConsentTest, AnEmergencyStopLatches) {
  drive();
  gate_.emergencyStop(now_, true);
  gate_.user(now_, {0.3, 0.0});
  EXPECT_EQ(ask(kForward).linear, 0.0);
  EXPECT_EQ(gate_.state(), GateState::kEmergencyStop);
  const auto refusal = gate_.arm(now_, kDocking);
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(refusal->state, GateState::kEmergencyStop);
  gate_.emergencyStop(now_, false);
  expectLatched(GateState::kEmergencyStop);
}

TEST_F(ConsentTest, AnEmergencyStopBeforeTheGoalRefusesIt) {
  gate_.emergencyStop(now_, true);
  wait(1.0);
  EXPECT_FALSE(arm());
  gate_.emergencyStop(now_, false);
  EXPECT_EQ(ask(kForward, 2.0).linear, 0.0);
}

TEST_F(ConsentTest, TheJoystickDrivesWhileDeflectedAndEndsTheDocking) {
  drive();
  for (int i = 0; i < 20; ++i) {
    gate_.user(now_, {-0.2, 0.0});
    ask(kForward, 0.05);
  }
  EXPECT_EQ(gate_.state(), GateState::kUser);
  EXPECT_LT(gate_.output(now_).linear, -0.1);
  EXPECT_FALSE(arm()) << "deflected";
  gate_.user(now_, {});
  EXPECT_EQ(ask(kForward, 0.5).linear, 0.0);
  expectLatched(GateState::kUser);
  gate_.user(now_, {0.2, 0.0});  // it needs no consent
  wait(0.4);
  EXPECT_EQ(gate_.state(), GateState::kUser);
}

TEST_F(ConsentTest, ASilentJoystickIsLetGo) {
  wait(1.0);
  gate_.user(now_, {0.3, 0.0});
  EXPECT_GT(wait(0.45).linear, 0.1);
  EXPECT_EQ(wait(0.5).linear, 0.0);
}

TEST_F(ConsentTest, AJoystickAtNeutralLeavesTheDockingAlone) {
  drive();
  for (int i = 0; i < 20; ++i) {
    gate_.user(now_, {0.01, -0.01});
    ask(kForward, 0.05);
  }
  EXPECT_EQ(gate_.state(), GateState::kRequest);
  EXPECT_NEAR(gate_.output(now_).linear, kForward.linear, 1e-9);
}

TEST_F(ConsentTest, AJoystickHeldAtTheStartOrThroughAStopHasToBeLetGoFirst) {
  const auto held = [this](double duration) {
    Velocity output;
    for (const double end = now_ + duration; now_ < end; now_ += 0.05) {
      gate_.user(now_, {0.3, 0.0});
      output = gate_.output(now_);
    }
    return output;
  };
  gate_.output(now_);
  EXPECT_EQ(held(3.0).linear, 0.0);
  EXPECT_EQ(gate_.status(now_).reason, "the joystick has to be let go before it drives");
  gate_.user(now_, {});
  EXPECT_GT(held(1.0).linear, 0.2);
  gate_.emergencyStop(now_, true);
  EXPECT_EQ(held(1.0).linear, 0.0);
  gate_.emergencyStop(now_, false);
  EXPECT_EQ(held(3.0).linear, 0.0);
  wait(0.6);
  EXPECT_GT(held(1.0).linear, 0.2);
}

TEST_F(ConsentTest, WhatIsNotFiniteLatches) {
  drive();
  ask({kNan, 0.0}, 0.05);
  expectLatched(GateState::kRefused);
  gate_.user(now_, {0.0, kNan});
  expectLatched(GateState::kRefused);
}

TEST_F(ConsentTest, SilenceBrakesFirstAndLatchesThen) {
  drive();
  EXPECT_LT(wait(0.4).linear, 0.4);
  EXPECT_EQ(gate_.state(), GateState::kStale);
  EXPECT_GT(ask(kForward, 0.5).linear, 0.2) << "a hiccup";
  ask(kForward, 1.0);
  EXPECT_EQ(wait(1.0).linear, 0.0);
  expectLatched(GateState::kStale);
}

TEST_F(ConsentTest, EndsByItselfSomeTimeAfterTheLastZero) {
  drive();
  ask({}, 0.5);
  wait(4.0);
  EXPECT_TRUE(gate_.status(now_).motion_allowed);
  wait(1.5);
  EXPECT_FALSE(gate_.status(now_).motion_allowed);
  EXPECT_EQ(gate_.status(now_).stopped_by, GateState::kStopped);
}

TEST_F(ConsentTest, AForeignSenderStopsTheChairAndDrivesNothing) {
  drive();
  gate_.request(now_, "/foreign", {0.1, 0.0});
  EXPECT_EQ(ask(kForward).linear, 0.0);
  EXPECT_EQ(gate_.status(now_).reason, "/docking sends velocity requests without consent");
  expectLatched(GateState::kFault);
  EXPECT_FALSE(arm("/foreign")) << "somebody else drives";
}

// The fault table's stamps: 10 s, 1 h, none, in the future; NaN too.
TEST_F(ConsentTest, StampsThatAreOldOrInTheFutureMoveNothing) {
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double age : {0.6, 10.0, 3600.0, infinite, -0.5, -3600.0, -infinite, kNan}) {
    drive();
    EXPECT_EQ(ask(kForward, 0.7, age).linear, 0.0) << age;
    wait(0.5);
    EXPECT_FALSE(gate_.status(now_).motion_allowed) << age;
    EXPECT_NE(gate_.status(now_).reason.find("stamp"), std::string::npos) << gate_.status(now_).reason;
    ask({}, 0.5);
  }
}

TEST_F(ConsentTest, AFaultRefusesAllUntilItIsGone) {
  drive();
  gate_.fault(now_, "two gates");
  gate_.user(now_, {0.3, 0.0});
  EXPECT_EQ(ask(kForward).linear, 0.0);
  EXPECT_EQ(gate_.state(), GateState::kFault);
  EXPECT_FALSE(arm());
  EXPECT_EQ(gate_.status(now_).reason, "two gates");
  gate_.fault(now_, "");
  expectLatched(GateState::kFault);
}

TEST_F(ConsentTest, AJumpOfTheClockEndsIt) {
  drive();
  now_ -= 50.0;
  EXPECT_LT(gate_.output(now_).linear, 0.41);
  EXPECT_EQ(ask(kForward, 1.0).linear, 0.0);
  expectLatched(GateState::kFault);
}

TEST_F(ConsentTest, ASilentEmergencyStopCountsAsPressed) {
  GateParameters p;
  p.emergency_stop_timeout = 0.3;
  gate_ = VelocityGate(p);
  gate_.output(now_);
  EXPECT_EQ(gate_.arm(now_, kDocking)->reason, "the emergency stop is silent, which counts as pressed");
  gate_.emergencyStop(now_, false);
  ASSERT_TRUE(arm());
  ask(kForward, 0.29);
  EXPECT_EQ(gate_.state(), GateState::kRequest);
  EXPECT_EQ(ask(kForward).linear, 0.0);
  EXPECT_EQ(gate_.state(), GateState::kEmergencyStop);
  gate_.emergencyStop(now_, false);
  EXPECT_EQ(ask(kForward, 0.2).linear, 0.0) << "latched";
}

TEST_F(ConsentTest, HoldToRunLetsRequestsPassWhileItIsHeld) {
  GateParameters p;
  p.hold_to_run = 1.0;
  gate_ = VelocityGate(p);
  gate_.output(now_);
  EXPECT_EQ(gate_.arm(now_, kDocking)->reason, "hold-to-run is not held");
  const auto held = [this](double duration) {
    Velocity output;
    for (const double end = now_ + duration; now_ < end;) {
      gate_.holdToRun(now_, true);
      output = ask(kForward, 0.05);
    }
    return output;
  };
  gate_.holdToRun(now_, true);
  ASSERT_TRUE(arm());
  EXPECT_GT(held(2.0).linear, 0.39);
  gate_.holdToRun(now_, false);
  EXPECT_EQ(gate_.status(now_).stop_reason, "hold-to-run was let go");
  EXPECT_EQ(gate_.status(now_).stopped_by, GateState::kUser);
  EXPECT_EQ(held(1.0).linear, 0.0) << "held again, without a new goal";
  ask({}, 0.4);
  gate_.holdToRun(now_, true);
  ASSERT_TRUE(arm());
  held(1.0);
  EXPECT_EQ(ask(kForward, 1.0).linear, 0.0) << "silence counts as let go";
}

TEST_F(ConsentTest, AnEmergencyStopMayHaveToBeReset) {
  GateParameters p;
  p.emergency_stop_reset = 1.0;
  gate_ = VelocityGate(p);
  drive();
  gate_.emergencyStop(now_, true);
  EXPECT_EQ(gate_.reset(now_)->reason, "the emergency stop is pressed");
  gate_.emergencyStop(now_, false);
  EXPECT_EQ(gate_.reset(now_)->reason, "the chair still moves");
  wait(1.0);
  EXPECT_FALSE(gate_.motorsEnabled(now_));
  EXPECT_FALSE(arm());
  gate_.user(now_, {0.3, 0.0});
  EXPECT_EQ(gate_.reset(now_)->reason, "the joystick is deflected");
  EXPECT_EQ(wait(0.4).linear, 0.0);
  gate_.user(now_, {});
  EXPECT_FALSE(gate_.reset(now_).has_value());
  EXPECT_TRUE(gate_.motorsEnabled(now_));
  EXPECT_TRUE(arm());
}

TEST_F(ConsentTest, FromOneSourceToAnotherTheSpeedDoesNotJump) {
  drive();
  Velocity previous = gate_.output(now_);
  for (int i = 0; i < 60; ++i) {
    now_ += 0.02;
    gate_.user(now_, {-0.3, -0.5});
    const Velocity output = gate_.output(now_);
    EXPECT_LE(std::abs(output.linear - previous.linear), 1.5 * 0.02 + 1e-9);
    EXPECT_LE(std::abs(output.angular - previous.angular), 3.0 * 0.02 + 1e-9);
    previous = output;
  }
  EXPECT_EQ(previous.linear, -0.3);
}

TEST_F(ConsentTest, ANewGoalOfTheSameNodeTakesOver) {
  drive();
  ASSERT_TRUE(arm());
  EXPECT_GT(ask(kForward).linear, 0.3);
}

}  // namespace
}  // namespace seater_safety
