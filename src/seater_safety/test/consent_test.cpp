// Consent: nothing moves by a request without it, and it ends for good with every fault.
#include "consent_fixture.h"

namespace seater_safety {
namespace {

TEST_F(ConsentTest, RequestsWithoutItMoveNothing) {
  EXPECT_EQ(ask(kForward, 2.0).linear, 0.0);
  EXPECT_EQ(gate_.state(), GateState::kStopped);
  EXPECT_GE(gate_.ignored(), 40u);
  EXPECT_EQ(gate_.status(now_).reason, "/docking sends velocity requests without consent");
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

// Motors that do not obey: they get their power back with the next goal, and not with the end of the fault.
TEST_F(ConsentTest, WithItsEndThePowerIsCutUntilTheNext) {
  drive();
  gate_.cutPower(now_, GateState::kWrongDirection, "drives backward");
  EXPECT_FALSE(gate_.motorsEnabled(now_));
  const Velocity output = gate_.output(now_);
  EXPECT_TRUE(output.linear == 0.0 && output.angular == 0.0) << "at once, not braked";
  EXPECT_EQ(gate_.state(), GateState::kWrongDirection);
  EXPECT_EQ(gate_.arm(now_, kDocking)->state, GateState::kWrongDirection) << "who asks is told the cause";
  gate_.fault(now_, "");
  wait(1.0);
  EXPECT_EQ(gate_.state(), GateState::kStopped);
  EXPECT_FALSE(gate_.motorsEnabled(now_));
  EXPECT_NE(gate_.status(now_).reason.find("power is cut"), std::string::npos);
  expectLatched(GateState::kWrongDirection);
  EXPECT_TRUE(gate_.motorsEnabled(now_));
}

TEST_F(ConsentTest, ThePowerThatWasCutIsBackWhenTheJoystickDrivesAgain) {
  gate_.cutPower(now_, GateState::kRunaway, "runs away");
  for (int i = 0; i < 50; ++i, wait(0.02)) gate_.user(now_, kForward);
  gate_.fault(now_, "");
  gate_.user(now_, kForward);
  EXPECT_EQ(wait(0.1).linear, 0.0) << "it has to be let go first";
  EXPECT_FALSE(gate_.motorsEnabled(now_));
  gate_.user(now_, {});
  gate_.user(now_, kForward);
  EXPECT_GT(wait(0.1).linear, 0.0);
  EXPECT_TRUE(gate_.motorsEnabled(now_));
}

TEST_F(ConsentTest, ANewGoalOfTheSameNodeTakesOver) {
  drive();
  ASSERT_TRUE(arm());
  EXPECT_GT(ask(kForward).linear, 0.3);
}

}  // namespace
}  // namespace seater_safety
