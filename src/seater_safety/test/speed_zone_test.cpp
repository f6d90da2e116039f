#include "seater_safety/speed_zone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(SpeedZone, CountsFromItsTimeUntilItIsForgotten) {
  SpeedZone zone;
  EXPECT_EQ(zone.limit(0.0, 0.0, 0.01), kInf);
  ASSERT_TRUE(zone.told(1.0, 0.15));
  EXPECT_EQ(zone.limit(0.99, 0.0, 0.01), kInf);
  EXPECT_EQ(zone.limit(1.0, 0.0, 0.01), 0.15);
  EXPECT_EQ(zone.limit(1.0 + kZoneTimeout, 0.0, 0.01), 0.15);
  EXPECT_EQ(zone.limit(1.01 + kZoneTimeout, 0.0, 0.01), kInf);
}

TEST(SpeedZone, WhatWasToldSinceTheConsentIsNotForgotten) {
  SpeedZone zone;
  EXPECT_EQ(zone.limit(0.0, 0.0, 0.01, 0.0), kInf);
  zone.told(1.0, 0.15);
  EXPECT_EQ(zone.limit(0.9, 0.0, 0.01, 0.5), kInf);
  EXPECT_EQ(zone.limit(100.0, 0.0, 0.01, 1.0), 0.15);
  EXPECT_EQ(zone.limit(100.0, 0.0, 0.01, 1.1), kInf);
}

// The joystick is not slow for ever because nobody says any more where the chair is; whoever docks is.
TEST(SpeedZone, ASilentOneHoldsForRequestsAndNotForTheJoystick) {
  VelocityGate gate{GateParameters{}};
  double now = 0.0, output = 0.0;
  gate.arm(now, "/docking");
  gate.speedLimit(now, 0.15);
  for (; now < 5.0; now += 0.05) {
    gate.request(now, "/docking", {0.4, 0.0});
    output = gate.output(now).linear;
  }
  EXPECT_DOUBLE_EQ(output, 0.15);
  for (; now < 8.0; now += 0.05) {
    gate.user(now, {0.4, 0.0});
    output = gate.output(now).linear;
  }
  EXPECT_DOUBLE_EQ(output, 0.4);
}

// A lock-step simulation tells it ahead, and tells the next before the last is in force.
TEST(SpeedZone, OneToldAheadDoesNotReplaceTheOneInForce) {
  SpeedZone zone;
  zone.told(1.0, 0.15);
  zone.told(1.5, 0.6);
  EXPECT_EQ(zone.limit(1.2, 0.0, 0.01), 0.15);
  EXPECT_EQ(zone.limit(1.5, 0.0, 0.01), 0.6);
}

TEST(SpeedZone, FallsWithinTheChange) {
  SpeedZone zone;
  zone.told(0.0, 0.15);
  EXPECT_DOUBLE_EQ(zone.limit(0.0, -0.5, 0.01), 0.49);
  EXPECT_DOUBLE_EQ(zone.limit(0.0, 0.155, 0.01), 0.15);
}

TEST(SpeedZone, WhatIsNoSpeedIsNotTaken) {
  SpeedZone zone;
  for (const double limit : {-0.1, kInf, std::nan("")}) EXPECT_FALSE(zone.told(0.0, limit)) << limit;
  EXPECT_FALSE(zone.told(std::nan(""), 0.1));
  EXPECT_EQ(zone.limit(0.0, 0.0, 0.01), kInf);
}

// Fault table: 0.30 m/s in the bay by joystick.
TEST(SpeedZone, HoldsForTheJoystickAndForRequestsBothWays) {
  for (const double asked : {0.5, -0.5}) {
    VelocityGate gate{GateParameters{}};
    double now = 0.0;
    gate.output(now);
    double fastest = 0.0;
    for (now = 1.0; now < 6.0; now += 0.02) {
      if (now > 3.0) gate.speedLimit(now, 0.15);
      gate.user(now, {asked, 0.0});
      const double before = std::abs(fastest);
      fastest = gate.output(now).linear;
      EXPECT_LE(before - std::abs(fastest), 0.5 * 0.02 + 1e-9) << "comfortable";
    }
    EXPECT_DOUBLE_EQ(fastest, asked > 0.0 ? 0.15 : -0.15);
  }
  VelocityGate gate{GateParameters{}};
  gate.arm(0.0, "/docking");
  double output = 0.0;
  for (double now = 0.0; now < 3.0; now += 0.05) {
    gate.speedLimit(now, 0.15);
    gate.request(now, "/docking", {0.4, 0.0});
    output = gate.output(now).linear;
  }
  EXPECT_DOUBLE_EQ(output, 0.15);
}

}  // namespace
}  // namespace seater_safety
