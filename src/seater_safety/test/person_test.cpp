// What a person does: emergency stop, joystick, hold-to-run. Each ends the consent for good.
#include "consent_fixture.h"

namespace seater_safety {
namespace {

using PersonTest = ConsentTest;

TEST_F(PersonTest, AnEmergencyStopLatches) {
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

TEST_F(PersonTest, AnEmergencyStopBeforeTheGoalRefusesIt) {
  gate_.emergencyStop(now_, true);
  wait(1.0);
  EXPECT_FALSE(arm());
  gate_.emergencyStop(now_, false);
  EXPECT_EQ(ask(kForward, 2.0).linear, 0.0);
}

TEST_F(PersonTest, TheJoystickDrivesWhileDeflectedAndEndsTheDocking) {
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

TEST_F(PersonTest, ASilentJoystickIsLetGo) {
  wait(1.0);
  gate_.user(now_, {0.3, 0.0});
  EXPECT_GT(wait(0.45).linear, 0.1);
  EXPECT_EQ(wait(0.5).linear, 0.0);
}

TEST_F(PersonTest, AJoystickAtNeutralLeavesTheDockingAlone) {
  drive();
  for (int i = 0; i < 20; ++i) {
    gate_.user(now_, {0.01, -0.01});
    ask(kForward, 0.05);
  }
  EXPECT_EQ(gate_.state(), GateState::kRequest);
  EXPECT_NEAR(gate_.output(now_).linear, kForward.linear, 1e-9);
}

TEST_F(PersonTest, AJoystickHeldAtTheStartOrThroughAStopHasToBeLetGoFirst) {
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

TEST_F(PersonTest, ASilentEmergencyStopCountsAsPressed) {
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
  EXPECT_EQ(gate_.status(now_).stop_reason, "the emergency stop is silent, which counts as pressed");
  gate_.emergencyStop(now_, false);
  EXPECT_EQ(ask(kForward, 0.2).linear, 0.0) << "latched";
}

TEST_F(PersonTest, HoldToRunLetsRequestsPassWhileItIsHeld) {
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

TEST_F(PersonTest, AnEmergencyStopMayHaveToBeReset) {
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

TEST_F(PersonTest, WhileChargingNothingMovesUntilAGoalUndocks) {
  GateParameters p;
  p.charging_inhibit = 1.0;
  gate_ = VelocityGate(p);
  drive();
  gate_.charging(now_, true);
  EXPECT_GT(ask(kForward, 0.5).linear, 0.39) << "a docking closes the contact before it is over";
  ask({}, 0.5);
  EXPECT_FALSE(arm()) << "another goal, though the last one's consent has not ended yet";
  wait(6.0);
  EXPECT_EQ(gate_.state(), GateState::kCharging);
  EXPECT_TRUE(gate_.motorsEnabled(now_));
  const auto refusal = gate_.arm(now_, kDocking);
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(refusal->state, GateState::kCharging);
  EXPECT_EQ(refusal->reason, "the charging contact is closed: undock first");
  gate_.user(now_, {0.3, 0.0});
  EXPECT_EQ(wait(0.4).linear, 0.0);
  EXPECT_EQ(gate_.status(now_).reason, refusal->reason);
  gate_.charging(now_, false);
  gate_.user(now_, {0.3, 0.0});
  EXPECT_EQ(wait(0.4).linear, 0.0) << "a joystick that is held when the contact opens";
  gate_.charging(now_, true);
  wait(1.0);
  ASSERT_FALSE(gate_.arm(now_, kDocking, true).has_value());
  EXPECT_LT(ask({-0.2, 0.0}).linear, -0.19);
  gate_.charging(now_, false);
  EXPECT_LT(ask({-0.2, 0.0}).linear, -0.19);
}

TEST_F(PersonTest, TheJoystickEndsAnUndockingButDoesNotDriveWhileCharging) {
  GateParameters p;
  p.charging_inhibit = 1.0;
  gate_ = VelocityGate(p);
  wait(1.0);
  gate_.charging(now_, true);
  ASSERT_FALSE(gate_.arm(now_, kDocking, true).has_value());
  ask({-0.2, 0.0});
  gate_.user(now_, {0.3, 0.0});
  EXPECT_EQ(wait(0.4).linear, 0.0);
  EXPECT_EQ(gate_.status(now_).stopped_by, GateState::kUser);
}

TEST_F(PersonTest, WithoutTheInhibitTheContactChangesNothing) {
  gate_.charging(now_, true);
  drive();
  ask({}, 0.5);
  gate_.user(now_, {0.3, 0.0});
  EXPECT_GT(wait(0.4).linear, 0.1);
}

TEST_F(PersonTest, FromOneSourceToAnotherTheSpeedDoesNotJump) {
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

}  // namespace
}  // namespace seater_safety
