// Python module seater_safety: the velocity gate and the motion monitor that the node safety_gate runs, for simulations
// without ROS. Meanings, units and what is refused: velocity_gate.h, motion_monitor.h.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "seater_safety/motion_monitor.h"
#include "seater_safety/velocity_gate.h"

namespace ss = seater_safety;
namespace py = pybind11;
using namespace pybind11::literals;

namespace {

constexpr const char* kHolder = "requester";

// Every parameter by name, because so many numbers in a row are too easily swapped.
ss::GateParameters parametersOf(std::map<std::string, double> values) {
  ss::GateParameters parameters;
  for (const ss::GateParameter& parameter : ss::gateParameters()) {
    const auto found = values.find(parameter.key);
    if (found == values.end()) throw py::value_error(std::string(parameter.key) + ": is missing");
    parameters.*parameter.value = found->second;
    values.erase(found);
  }
  if (!values.empty()) throw py::value_error(values.begin()->first + ": is no parameter of the safety gate");
  return parameters;
}

py::list describeParameters() {
  const ss::GateParameters defaults;
  py::list all;
  for (const ss::GateParameter& parameter : ss::gateParameters()) {
    all.append(py::dict("file"_a = parameter.file, "key"_a = parameter.key, "default"_a = defaults.*parameter.value,
                        "unit"_a = parameter.unit, "low"_a = parameter.low, "high"_a = parameter.high,
                        "text"_a = parameter.text));
  }
  return all;
}

void bindGate(py::module_& m) {
  py::enum_<ss::GateState>(m, "GateState", "Whom the output follows, or why it goes to zero.")
      .value("STOPPED", ss::GateState::kStopped)
      .value("REQUEST", ss::GateState::kRequest)
      .value("USER", ss::GateState::kUser)
      .value("STALE", ss::GateState::kStale)
      .value("REFUSED", ss::GateState::kRefused)
      .value("EMERGENCY_STOP", ss::GateState::kEmergencyStop)
      .value("FAULT", ss::GateState::kFault)
      .value("RUNAWAY", ss::GateState::kRunaway)
      .value("WRONG_DIRECTION", ss::GateState::kWrongDirection)
      .value("OBSTACLE", ss::GateState::kObstacle)
      .value("CHARGING", ss::GateState::kCharging);
  py::class_<ss::VelocityGate>(m, "VelocityGate",
                               "The last gate before the motors. Speeds (v [m/s], omega [rad/s]), times [s].")
      .def(py::init([](const py::kwargs& values) {
             return ss::VelocityGate(parametersOf(values.cast<std::map<std::string, double>>()));
           }),
           "Takes every parameter by name. Raises ValueError: missing, unknown or out of range.")
      .def(
          "arm",
          [](ss::VelocityGate& gate, double now) {
            const auto refusal = gate.arm(now, kHolder);
            return refusal ? refusal->reason : std::string();
          },
          "now"_a, "Requests pass from now on; else why not.")
      .def(
          "request",
          [](ss::VelocityGate& gate, double now, double v, double omega) {
            gate.request(now, kHolder, {v, omega});
          },
          "now"_a, "v"_a, "omega"_a, "A request of the docking controller; not finite: the consent ends.")
      .def(
          "user",
          [](ss::VelocityGate& gate, double now, double v, double omega) {
            gate.user(now, {v, omega});
          },
          "now"_a, "v"_a, "omega"_a, "The joystick, which has precedence while it is deflected.")
      .def(
          "obstacles",
          [](ss::VelocityGate& gate, double now, double measured, const std::vector<std::pair<double, double>>& points,
             const std::string& blocked) {
            std::vector<ss::Point> seen;
            for (const auto& [x, y] : points) seen.push_back({x, y});
            gate.obstacles(now, measured, "sensor", seen, blocked);
          },
          "now"_a, "measured"_a, "points"_a, "blocked"_a = "",
          "All that a sensor of obstacles has seen at the time `measured`: (x, y) [m] in base_link.")
      .def("emergency_stop", &ss::VelocityGate::emergencyStop, "now"_a, "pressed"_a)
      .def(
          "output",
          [](ss::VelocityGate& gate, double now) {
            const ss::Velocity velocity = gate.output(now);
            return py::make_tuple(velocity.linear, velocity.angular);
          },
          "now"_a, "(v, omega) for the motors at `now`.")
      .def_property_readonly("state", &ss::VelocityGate::state)
      .def(
          "reason", [](const ss::VelocityGate& gate, double now) { return gate.status(now).reason; }, "now"_a,
          "The state in words.")
      .def_property_readonly("refused", &ss::VelocityGate::refused, "requests that were not finite")
      .def_property_readonly("limited", &ss::VelocityGate::limited, "outputs that a speed limit changed");
}

void bindMonitor(py::module_& m) {
  py::class_<ss::MotionMonitor>(
      m, "MotionMonitor", "Whether the chair moves as it was told to. Speeds (v [m/s], omega [rad/s]), times [s].")
      .def(py::init([](const py::kwargs& values) {
             const ss::GateParameters parameters = parametersOf(values.cast<std::map<std::string, double>>());
             const std::string problem = parameters.check();
             if (!problem.empty()) throw py::value_error(problem);
             return ss::MotionMonitor(parameters);
           }),
           "Takes every parameter of the gate by name. Raises ValueError: missing, unknown or out of range.")
      .def(
          "sent",
          [](ss::MotionMonitor& monitor, double now, double v, double omega) {
            monitor.sent(now, {v, omega});
          },
          "now"_a, "v"_a, "omega"_a, "What the motors are told.")
      .def(
          "measured",
          [](ss::MotionMonitor& monitor, double now, double v, double omega) {
            return monitor.measured(now, {v, omega});
          },
          "now"_a, "v"_a, "omega"_a, "What the odometry says; True when it brings the fault.")
      .def_property_readonly(
          "cause", [](const ss::MotionMonitor& monitor) { return monitor.fault().cause; }, "RUNAWAY or WRONG_DIRECTION")
      .def_property_readonly(
          "reason", [](const ss::MotionMonitor& monitor) { return monitor.fault().reason; },
          "What is wrong, in words; empty: nothing.");
}

}  // namespace

PYBIND11_MODULE(seater_safety, m) {
  m.doc() = "The velocity gate before the motors and the motion monitor (docs/safety.md).";
  m.def("describe_parameters", &describeParameters, "Key, default, unit, range and meaning of every parameter.");
  bindGate(m);
  bindMonitor(m);
}
