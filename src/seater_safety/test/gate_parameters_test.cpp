#include "seater_safety/gate_parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

TEST(GateParameters, DefaultsAreAllowed) {
  EXPECT_EQ(GateParameters{}.check(), "");
}

TEST(GateParameters, EveryValueOutsideItsRangeIsNamed) {
  for (const GateParameter& parameter : gateParameters()) {
    for (const double value : {parameter.low - 0.01, parameter.high * 1.01, -1.0, std::nan("")}) {
      GateParameters p;
      p.*parameter.value = value;
      EXPECT_EQ(p.check().rfind(parameter.key + std::string(": is "), 0), 0u) << parameter.key << " " << value;
      EXPECT_THROW(VelocityGate{p}, std::invalid_argument) << parameter.key << " " << value;
    }
  }
}

// Of the fault table: values that were accepted once.
TEST(GateParameters, ValuesWithWhichAChairDoesNotStopAreRefused) {
  GateParameters p;
  p.a_stop = 0.01;
  EXPECT_NE(p.check().find("a_stop: is 0.01"), std::string::npos);
  p = {};
  p.request_timeout = 1e6;
  EXPECT_NE(p.check().find("request_timeout: is 1e+06"), std::string::npos);
  p = {};
  p.v_max = 50.0;
  EXPECT_NE(p.check().find("v_max: is 50"), std::string::npos);
}

TEST(GateParameters, ValuesThatDoNotFitTogetherAreRefused) {
  GateParameters p;
  p.a_max = 2.0;
  EXPECT_EQ(p.check(), "a_stop: is 1.5, must be at least a_max of the chair");
  p = {};
  p.consent_timeout = 0.2;
  EXPECT_EQ(p.check(), "consent_timeout: is 0.2, must be at least request_timeout");
}

TEST(GateParameters, UnknownAndMissingKeysAreNamed) {
  std::vector<std::string> keys;
  for (const GateParameter& parameter : gateParameters()) {
    if (parameter.file == std::string("safety")) keys.emplace_back(parameter.key);
  }
  EXPECT_EQ(checkKeys("safety", keys), "");
  keys.emplace_back("a_stopp");
  EXPECT_EQ(checkKeys("safety", keys), "a_stopp: is no parameter of the safety gate");
  keys = {"a_stop"};
  EXPECT_EQ(checkKeys("safety", keys), "alpha_stop: is missing");
}

}  // namespace
}  // namespace seater_safety
