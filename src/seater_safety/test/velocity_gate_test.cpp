#include "seater_safety/velocity_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace seater_safety {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// Asks for the same velocity at 20 Hz for `duration` and returns the last output.
Velocity hold(VelocityGate& gate, double& now, double duration, const Velocity& velocity) {
  Velocity output;
  for (const double end = now + duration; now < end; now += 0.05) {
    gate.request(now, velocity);
    output = gate.output(now);
  }
  return output;
}

TEST(VelocityGate, IsZeroUntilSomebodyAsks) {
  VelocityGate gate{GateParameters{}};
  const Velocity output = gate.output(10.0);
  EXPECT_EQ(output.linear, 0.0);
  EXPECT_EQ(output.angular, 0.0);
  EXPECT_EQ(gate.state(), GateState::kStopped);
}

TEST(VelocityGate, LetsAPermittedRequestThrough) {
  VelocityGate gate{GateParameters{}};
  double now = 1.0;
  const Velocity output = hold(gate, now, 2.0, {0.3, -0.4});
  EXPECT_DOUBLE_EQ(output.linear, 0.3);
  EXPECT_DOUBLE_EQ(output.angular, -0.4);
  EXPECT_EQ(gate.limited(), 0u);
}

TEST(VelocityGate, LimitsSpeedOfEachAxisByItsOwnLimit) {
  VelocityGate gate{GateParameters{}};
  double now = 1.0;
  EXPECT_DOUBLE_EQ(hold(gate, now, 4.0, {5.0, 5.0}).linear, 0.6);
  EXPECT_DOUBLE_EQ(gate.output(now).angular, 0.8);
  EXPECT_DOUBLE_EQ(hold(gate, now, 4.0, {-5.0, -5.0}).linear, -0.3);
  EXPECT_DOUBLE_EQ(gate.output(now).angular, -0.8);
  EXPECT_GT(gate.limited(), 0u);
}

TEST(VelocityGate, SpeedsUpWithinTheAccelerationLimit) {
  const GateParameters p;
  VelocityGate gate{p};
  double previous = gate.output(0.0).linear;
  for (double now = 0.05; now < 3.0; now += 0.05) {
    gate.request(now, {0.6, 0.0});
    const double linear = gate.output(now).linear;
    EXPECT_LE(linear - previous, p.a_max * 0.05 + 1e-12);
    previous = linear;
  }
  EXPECT_DOUBLE_EQ(previous, 0.6);
}

TEST(VelocityGate, APauseIsNoLicenceToJump) {
  VelocityGate gate{GateParameters{}};
  gate.output(0.0);
  gate.request(100.0, {0.6, 0.0});
  EXPECT_LE(gate.output(100.0).linear, 0.05 + 1e-12);
}

TEST(VelocityGate, StopsWhenRequestsEnd) {
  const GateParameters p;
  VelocityGate gate{p};
  double now = 0.0;
  hold(gate, now, 2.0, {0.6, 0.5});
  const double end = now + p.request_timeout + 0.6 / p.a_stop + 0.05;
  Velocity output{1.0, 1.0};
  for (; now < end; now += 0.02) output = gate.output(now);
  EXPECT_EQ(output.linear, 0.0);
  EXPECT_EQ(output.angular, 0.0);
}

TEST(VelocityGate, AZeroRequestIsServedByTheStoppingLimit) {
  const GateParameters p;
  VelocityGate gate{p};
  double now = 0.0;
  hold(gate, now, 2.0, {0.6, 0.0});
  EXPECT_GT(hold(gate, now, 0.3, {}).linear, 0.0);
  EXPECT_EQ(hold(gate, now, 0.2, {}).linear, 0.0);
}

TEST(VelocityGate, WhatIsNotFiniteStopsTheChair) {
  for (const Velocity& bad : {Velocity{kNan, 0.0}, Velocity{0.0, kNan}, Velocity{kInf, 0.0}, Velocity{0.1, -kInf}}) {
    VelocityGate gate{GateParameters{}};
    double now = 0.0;
    hold(gate, now, 2.0, {0.6, 0.5});
    gate.request(now, bad);
    const Velocity first = gate.output(now);
    EXPECT_TRUE(std::isfinite(first.linear) && std::isfinite(first.angular));
    EXPECT_LT(first.linear, 0.6);
    EXPECT_EQ(gate.state(), GateState::kRefused);
    const Velocity last = hold(gate, now, 1.0, bad);
    EXPECT_EQ(last.linear, 0.0);
    EXPECT_EQ(last.angular, 0.0);
    EXPECT_GT(gate.refused(), 0u);
  }
}

TEST(VelocityGate, TheJoystickRulesWhileItIsFresh) {
  const GateParameters p;
  VelocityGate gate{p};
  double now = 0.0;
  hold(gate, now, 2.0, {0.5, 0.0});
  gate.user(now, {-0.1, 0.0});
  hold(gate, now, 0.45, {0.5, 0.0});
  EXPECT_EQ(gate.state(), GateState::kUser);
  EXPECT_LE(gate.output(now).linear, 0.0);
  EXPECT_GT(hold(gate, now, 1.0, {0.5, 0.0}).linear, 0.3);
  EXPECT_EQ(gate.state(), GateState::kRequest);
}

TEST(VelocityGate, EmergencyStopOverrulesAll) {
  VelocityGate gate{GateParameters{}};
  double now = 0.0;
  hold(gate, now, 2.0, {0.6, 0.5});
  gate.emergencyStop(true);
  gate.user(now, {0.3, 0.0});
  EXPECT_EQ(hold(gate, now, 1.0, {0.6, 0.5}).linear, 0.0);
  EXPECT_EQ(gate.state(), GateState::kEmergencyStop);
  gate.emergencyStop(false);
  EXPECT_GT(hold(gate, now, 2.0, {0.6, 0.5}).linear, 0.5);
}

TEST(VelocityGate, ReversingPassesThroughZero) {
  VelocityGate gate{GateParameters{}};
  double now = 0.0;
  double previous = hold(gate, now, 2.0, {0.2, 0.0}).linear;
  bool stood = false;
  for (int i = 0; i < 20; ++i) {
    const double linear = hold(gate, now, 0.05, {-0.2, 0.0}).linear;
    stood = stood || (previous > 0.0 && linear == 0.0);
    previous = linear;
  }
  EXPECT_TRUE(stood);
}

TEST(VelocityGate, RefusesParametersThatAreNotPositive) {
  GateParameters p;
  p.a_stop = 0.0;
  EXPECT_THROW(VelocityGate{p}, std::invalid_argument);
  p = GateParameters{};
  p.request_timeout = kNan;
  EXPECT_NE(p.check().find("request_timeout"), std::string::npos);
}

}  // namespace
}  // namespace seater_safety

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
