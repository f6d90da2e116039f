// Whatever comes in, in whatever order: random sequences of inputs against a small model of what may move the chair.
//
// SEATER_GATE_SEQUENCES sets how many; a failure names the seed of its sequence.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "property_model.h"
#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::string kHolders[] = {"/docking", "/other"};

class Sequence {
 public:
  explicit Sequence(unsigned seed) : random_(seed), gate_(drawParameters()) {
    model_.p = parameters_;
    now_ = uniform(0.0, 1e6);
    model_.user_at = model_.locked_at = now_;
    previous_ = gate_.output(now_);
    model_.look(now_);
  }

  // Empty, or what is wrong.
  std::string run() {
    const int length = 10 + static_cast<int>(uniform(0.0, 60.0));
    for (int i = 0; i < length; ++i) {
      input();
      const std::string wrong = step(uniform(0.0, 1.0) < 0.05 ? uniform(0.1, 2.0) : uniform(0.0, 0.06));
      if (!wrong.empty()) return wrong;
    }
    return end();
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }

  const GateParameters& drawParameters() {
    for (const GateParameter& parameter : gateParameters()) {
      if (chance(0.5)) parameters_.*parameter.value = uniform(parameter.low, std::min(parameter.high, 20.0));
    }
    if (chance(0.7)) parameters_.emergency_stop_timeout = 0.0;
    parameters_.emergency_stop_reset = std::round(parameters_.emergency_stop_reset);
    parameters_.obstacle_joystick = std::round(parameters_.obstacle_joystick);
    parameters_.hold_to_run = chance(0.2) ? 1.0 : 0.0;
    parameters_.charging_inhibit = chance(0.3) ? 1.0 : 0.0;
    if (!parameters_.check().empty()) parameters_ = GateParameters{};
    return parameters_;
  }

  Velocity draw() {
    if (chance(0.2)) return {};
    if (chance(0.02)) return {kNan, 0.1};
    if (chance(0.02)) return {0.1, std::numeric_limits<double>::infinity()};
    const double scale = chance(0.1) ? 1e6 : 1.0;
    return {scale * uniform(-1.0, 1.0), scale * uniform(-1.0, 1.0)};
  }

  void input() {
    const double kind = uniform(0.0, 1.0);
    if (kind < 0.55) {
      request(chance(0.97) ? 0 : 1, draw(), chance(0.93) ? uniform(-0.2, 0.1) : uniform(-5000.0, 5000.0));
    } else if (kind < 0.66) {
      user(chance(0.6) ? Velocity{uniform(-0.002, 0.002), 0.0} : draw());
    } else if (kind < 0.68) {
      see();
    } else if (kind < 0.75) {
      press(chance(0.3));
    } else if (kind < 0.79) {
      fault(chance(0.3));
    } else if (kind < 0.80) {
      cutPower();
    } else if (kind < 0.81) {
      zone(chance(0.9) ? uniform(0.0, 1.0) : -1.0);
    } else if (kind < 0.83) {
      holdToRun(chance(0.8));
    } else if (kind < 0.84) {
      charge(chance(0.5));
    } else if (kind < 0.95) {
      arm(chance(0.9) ? 0 : 1, chance(0.2));
    } else if (kind < 0.98) {
      reset();
    } else if (chance(0.2)) {
      jump();
    }
  }

  void request(int sender, const Velocity& velocity, double age) {
    gate_.request(now_, kHolders[sender], velocity, age);
    const bool zero = velocity.linear == 0.0 && velocity.angular == 0.0;
    if (!zero) model_.insisted = now_;
    const bool finite = std::isfinite(velocity.linear) && std::isfinite(velocity.angular);
    if (!finite || (model_.holder >= 0 && sender != model_.holder)) model_.holder = -1;
    if (model_.holder < 0) return;
    model_.awry = age > parameters_.request_max_age || age < -kLateness;
    if (model_.awry) return;
    model_.accepted = now_;
    model_.asks = true;
    model_.zero = zero;
  }

  void user(const Velocity& velocity) {
    gate_.user(now_, velocity);
    model_.look(now_);
    const bool finite = std::isfinite(velocity.linear) && std::isfinite(velocity.angular);
    if (!finite) model_.holder = -1;
    const double most = finite ? std::max(std::abs(velocity.linear), std::abs(velocity.angular)) : 0.0;
    model_.deflected = most > parameters_.user_neutral;
    model_.user_at = now_;
    if (model_.deflected) model_.holder = -1;
    if (!model_.deflected && !model_.stopped(now_)) model_.let_go = true;
  }

  void press(bool pressed) {
    gate_.emergencyStop(now_, pressed);
    model_.pressed = pressed;
    model_.heard = true;
    model_.pressed_at = now_;
    model_.look(now_);
  }

  void fault(bool faulty) {
    gate_.fault(now_, faulty ? "fault" : "");
    model_.faulty = faulty;
    model_.look(now_);
  }

  void cutPower() {
    gate_.cutPower(now_, GateState::kRunaway, "fault");
    model_.faulty = model_.powerless = true;
    previous_ = {};
    model_.look(now_);
  }

  void holdToRun(bool held) {
    gate_.holdToRun(now_, held);
    model_.hold = held;
    model_.hold_at = now_;
    model_.look(now_);
  }

  // No source is required, and none is blocked: points only ever slow down.
  void see() {
    std::vector<Point> points(static_cast<std::size_t>(uniform(0.0, 5.0)));
    for (Point& point : points) point = {uniform(-2.0, 2.0), uniform(-2.0, 2.0)};
    gate_.obstacles(now_, now_ - uniform(-0.1, 1.0), chance(0.5) ? "scan" : "depth", points);
  }

  void zone(double limit) {
    gate_.speedLimit(now_, limit);
    if (limit < 0.0) return;
    model_.zone = limit;
    model_.zone_from = now_;
  }

  void charge(bool closed) {
    gate_.charging(now_, closed);
    model_.look(now_);
    model_.charging = closed;
    model_.look(now_);
  }

  void arm(int holder, bool undock) {
    const bool granted = !gate_.arm(now_, kHolders[holder], undock).has_value();
    model_.look(now_);
    const bool deflected = model_.deflected && now_ - model_.user_at <= parameters_.user_timeout;
    const bool insists = now_ - model_.insisted <= parameters_.request_timeout;
    if (granted && (model_.stopped(now_) || !model_.held(now_) || deflected || (model_.charges() && !undock) ||
                    (model_.holder < 0 && insists) || (model_.holder >= 0 && model_.holder != holder))) {
      wrong_ = "a consent was given though something speaks against it";
    }
    if (!granted) return;
    model_.holder = holder;
    model_.powerless = false;
    model_.accepted = now_;
    model_.asks = model_.awry = false;
    model_.zero = true;
  }

  void reset() {
    if (gate_.reset(now_).has_value()) return;
    if (model_.pressed || previous_.linear != 0.0 || previous_.angular != 0.0) wrong_ = "reset while pressed or moving";
    model_.reset_due = false;
  }

  void jump() {
    now_ -= uniform(1.0, 100.0);
    gate_.output(now_);
    model_.holder = -1;
    model_.insisted = model_.zone_from = -1e9;
    model_.deflected = model_.let_go = model_.hold = false;
    model_.user_at = model_.locked_at = model_.pressed_at = now_;
    previous_ = gate_.output(now_);
  }

  std::string step(double duration) {
    if (!wrong_.empty()) return wrong_;
    now_ += duration;
    duration_ = duration;
    const Velocity output = gate_.output(now_);
    model_.look(now_);
    if (!model_.stopped(now_) && model_.userDrives(now_)) model_.powerless = false;
    const std::string wrong = judge(output, std::min(duration, 0.1) + 1e-9);
    previous_ = output;
    return wrong;
  }

  std::string judge(const Velocity& output, double duration) const {
    const GateParameters& p = parameters_;
    if (duration_ > 0.3) return output.linear == 0.0 && output.angular == 0.0 ? "" : "drives on after a silence";
    if (!std::isfinite(output.linear) || !std::isfinite(output.angular)) return "not finite";
    if (output.linear > p.v_max || output.linear < -p.v_reverse_max) return "too fast";
    if (std::abs(output.angular) > p.omega_max) return "turns too fast";
    const double zone = std::max(model_.zone, std::abs(previous_.linear) - p.a_max * (duration - 2e-9));
    if (now_ - model_.zone_from < kZoneTimeout && std::abs(output.linear) > zone) return "too fast for the place";
    const double slower = std::abs(previous_.linear) - std::abs(output.linear);
    if (slower > p.a_stop * duration || -slower > p.a_max * duration) return "change of speed";
    if (std::abs(output.linear - previous_.linear) > std::max(p.a_max, p.a_stop) * duration) return "reversed at once";
    if (std::abs(output.angular - previous_.angular) > std::max(p.alpha_max, p.alpha_stop) * duration) {
      return "change of turning";
    }
    if (model_.powerless && gate_.motorsEnabled(now_)) return "power though it was cut";
    if (model_.mayMove(now_)) return {};
    const double brake = std::min(std::abs(previous_.linear), 0.999 * p.a_stop * (duration - 1e-9));
    if (slower < brake - 1e-9) return "does not brake though nobody may move it";
    if (std::abs(output.angular) > std::abs(previous_.angular)) return "turns though nobody may move it";
    return {};
  }

  // At the end nobody asks any more: at rest in time.
  std::string end() {
    const GateParameters& p = parameters_;
    const double braking = std::max(std::max(p.v_max, p.v_reverse_max) / p.a_stop, p.omega_max / p.alpha_stop);
    const double limit = now_ + std::max(p.request_timeout, p.user_timeout) + braking + 0.1;
    while (now_ < limit) {
      const std::string wrong = step(0.02);
      if (!wrong.empty()) return wrong;
    }
    return previous_.linear == 0.0 && previous_.angular == 0.0 ? "" : "not at rest";
  }

  std::mt19937 random_;
  GateParameters parameters_;
  VelocityGate gate_;
  Model model_;
  double now_ = 0.0, duration_ = 0.0;  // [s] the last step's
  Velocity previous_;
  std::string wrong_;
};

TEST(VelocityGateProperty, HoldsForRandomSequences) {
  const char* given = std::getenv("SEATER_GATE_SEQUENCES");
  const unsigned sequences = given == nullptr ? 100000 : static_cast<unsigned>(std::strtoul(given, nullptr, 10));
  for (unsigned seed = 1; seed <= sequences; ++seed) ASSERT_EQ(Sequence(seed).run(), "") << "seed " << seed;
}

}  // namespace
}  // namespace seater_safety
