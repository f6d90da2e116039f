// Python module seater_safety: the velocity gate that the node safety_gate runs, for simulations without ROS. Meanings,
// units and what is refused: velocity_gate.h.
#include <pybind11/pybind11.h>

#include "seater_safety/velocity_gate.h"

namespace ss = seater_safety;
namespace py = pybind11;
using namespace pybind11::literals;

namespace {

/// Every parameter by name, because nine numbers in a row are too easily swapped.
ss::GateParameters parametersOf(double v_max, double v_reverse_max, double omega_max, double a_max, double alpha_max,
                                double a_stop, double alpha_stop, double request_timeout, double user_timeout) {
  return {v_max, v_reverse_max, omega_max, a_max, alpha_max, a_stop, alpha_stop, request_timeout, user_timeout};
}

void bindGate(py::module_& m) {
  py::enum_<ss::GateState>(m, "GateState", "Whom the output follows, or why it goes to zero.")
      .value("STOPPED", ss::GateState::kStopped)
      .value("REQUEST", ss::GateState::kRequest)
      .value("USER", ss::GateState::kUser)
      .value("STALE", ss::GateState::kStale)
      .value("REFUSED", ss::GateState::kRefused)
      .value("EMERGENCY_STOP", ss::GateState::kEmergencyStop);
  py::class_<ss::VelocityGate>(m, "VelocityGate",
                               "The last gate before the motors. Speeds (v [m/s], omega [rad/s]), times [s].")
      .def(py::init([](double v_max, double v_reverse_max, double omega_max, double a_max, double alpha_max,
                       double a_stop, double alpha_stop, double request_timeout, double user_timeout) {
             return ss::VelocityGate(parametersOf(v_max, v_reverse_max, omega_max, a_max, alpha_max, a_stop, alpha_stop,
                                                  request_timeout, user_timeout));
           }),
           py::kw_only(), "v_max"_a, "v_reverse_max"_a, "omega_max"_a, "a_max"_a, "alpha_max"_a, "a_stop"_a,
           "alpha_stop"_a, "request_timeout"_a, "user_timeout"_a, "Raises ValueError: not finite, or not above zero.")
      .def(
          "request",
          [](ss::VelocityGate& gate, double now, double v, double omega) {
            gate.request(now, {v, omega});
          },
          "now"_a, "v"_a, "omega"_a, "A request of the docking controller; not finite: refused, counts as zero.")
      .def(
          "user",
          [](ss::VelocityGate& gate, double now, double v, double omega) {
            gate.user(now, {v, omega});
          },
          "now"_a, "v"_a, "omega"_a, "The joystick, which has precedence while it is recent.")
      .def("emergency_stop", &ss::VelocityGate::emergencyStop, "pressed"_a)
      .def(
          "output",
          [](ss::VelocityGate& gate, double now) {
            const ss::Velocity velocity = gate.output(now);
            return py::make_tuple(velocity.linear, velocity.angular);
          },
          "now"_a, "(v, omega) for the motors at `now`.")
      .def_property_readonly("state", &ss::VelocityGate::state)
      .def_property_readonly("refused", &ss::VelocityGate::refused, "requests that were not finite")
      .def_property_readonly("limited", &ss::VelocityGate::limited, "outputs that a speed limit changed");
}

}  // namespace

PYBIND11_MODULE(seater_safety, m) {
  m.doc() = "The velocity gate before the motors (docs/reference/interfaces.md).";
  bindGate(m);
}
