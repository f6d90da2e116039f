// Parameter structs described for Python: what docs/reference/parameters.md is generated from.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <vector>

namespace seater_python {

namespace py = pybind11;

/// Lists the entries of a self-describing parameter struct (strict_yaml.h) in its own order, each a dict: key (full,
/// groups before a slash), default, unit, low, high, choices, text. What an entry does not have is None; an entry
/// without a default is a group.
class Describer {
 public:
  explicit Describer(std::string prefix = "") : prefix_(std::move(prefix)) {}

  void number(const char* key, double& value, const char* unit, double low, double high, const char* meaning) {
    add(key, meaning, py::float_(value), py::str(unit), py::float_(low), py::float_(high), py::none());
  }
  void integer(const char* key, int& value, const char* unit, int low, int high, const char* meaning) {
    add(key, meaning, py::int_(value), py::str(unit), py::int_(low), py::int_(high), py::none());
  }
  void boolean(const char* key, bool& value, const char* meaning) {
    add(key, meaning, py::bool_(value), py::none(), py::none(), py::none(), py::none());
  }
  void choice(const char* key, std::string& value, const std::vector<std::string>& allowed, const char* meaning) {
    add(key, meaning, py::str(value), py::none(), py::none(), py::none(), py::cast(allowed));
  }
  template <typename Struct>
  void group(const char* key, Struct& value, const char* meaning) {
    add(key, meaning, py::none(), py::none(), py::none(), py::none(), py::none());
    Describer inner(prefix_ + key + "/");
    value.visit(inner);
    entries_ += inner.entries_;
  }

  const py::list& entries() const { return entries_; }

 private:
  void add(const char* key, const char* text, const py::object& value, const py::object& unit, const py::object& low,
           const py::object& high, const py::object& choices) {
    using namespace pybind11::literals;
    entries_.append(py::dict("key"_a = prefix_ + key, "text"_a = text, "default"_a = value, "unit"_a = unit,
                             "low"_a = low, "high"_a = high, "choices"_a = choices));
  }

  std::string prefix_;
  py::list entries_;
};

template <typename Struct>
py::list described(Struct value) {
  Describer describer;
  value.visit(describer);
  return describer.entries();
}

}  // namespace seater_python
