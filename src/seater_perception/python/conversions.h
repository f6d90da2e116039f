// NumPy arrays and Python mappings as the library takes them.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <mutex>
#include <opencv2/core.hpp>
#include <utility>

namespace seater_python {

namespace py = pybind11;

/// An object of the library that serves one thread at a time, made safe for Python: calls run without the interpreter's
/// lock, and those of other threads on the same object wait for their turn.
template <typename Object>
class OneAtATime {
 public:
  template <typename... Arguments>
  explicit OneAtATime(Arguments&&... arguments) : object_(std::forward<Arguments>(arguments)...) {}

  /// Calls work(object). Must be called with the interpreter's lock held; `work` must not touch Python objects.
  template <typename Work>
  auto call(const Work& work) {
    const py::gil_scoped_release release;  // before waiting: who works may need it to return
    const std::lock_guard<std::mutex> lock(mutex_);
    return work(object_);
  }

 private:
  Object object_;
  std::mutex mutex_;
};

/// The image without a copy: (height, width) of uint8 or uint16, C-contiguous; TypeError otherwise. Valid as long as
/// the array lives.
inline cv::Mat asMat(const py::array& array) {
  // Equivalent, not identical: an array that came out of another process has a dtype object of its own.
  const bool bytes = py::isinstance<py::array_t<std::uint8_t>>(array);
  if (!bytes && !py::isinstance<py::array_t<std::uint16_t>>(array)) {
    throw py::type_error("image: dtype must be uint8 or uint16");
  }
  if (array.ndim() != 2 || !(array.flags() & py::array::c_style)) {
    throw py::type_error("image: must be a C-contiguous array of shape (height, width)");
  }
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), bytes ? CV_8UC1 : CV_16UC1,
          const_cast<void*>(array.data())};
}

/// What yaml.safe_load gives, as the strict readers take it. Text counts as quoted: "0.5" is not a number.
inline YAML::Node yaml(const py::handle& value) {
  if (value.is_none()) return YAML::Node(YAML::NodeType::Null);
  if (py::isinstance<py::bool_>(value)) return YAML::Node(value.cast<bool>());
  if (py::isinstance<py::int_>(value)) return YAML::Node(value.cast<long long>());
  if (py::isinstance<py::float_>(value)) return YAML::Node(value.cast<double>());
  if (py::isinstance<py::str>(value)) {
    YAML::Node node(value.cast<std::string>());
    node.SetTag("!");
    return node;
  }
  if (py::isinstance<py::dict>(value)) {
    YAML::Node node(YAML::NodeType::Map);
    for (const auto& item : value.cast<py::dict>()) node[py::str(item.first).cast<std::string>()] = yaml(item.second);
    return node;
  }
  if (py::isinstance<py::sequence>(value)) {
    YAML::Node node(YAML::NodeType::Sequence);
    for (const auto& item : value.cast<py::sequence>()) node.push_back(yaml(item));
    return node;
  }
  throw py::type_error("parameters: must be made of dict, list, str, bool, int and float");
}

/// A pose as a 4x4 matrix; the upper left 3x3 part has to be a rotation.
inline Eigen::Isometry3d pose(const Eigen::Matrix4d& matrix) {
  Eigen::Isometry3d T;
  T.matrix() = matrix;
  if (!matrix.allFinite() || !T.linear().isUnitary(1e-6) || T.linear().determinant() < 0.0) {
    throw py::value_error("pose: the upper left 3x3 part must be a rotation");
  }
  return T;
}

/// Writes a self-describing parameter struct (strict_yaml.h) into a dict.
class DictWriter {
 public:
  py::dict dict;

  void number(const char* key, double& value, const char*, double, double, const char*) { dict[key] = value; }
  void integer(const char* key, int& value, const char*, int, int, const char*) { dict[key] = value; }
  void boolean(const char* key, bool& value, const char*) { dict[key] = value; }
  void text(const char* key, std::string& value, const char*) { dict[key] = value; }
  void choice(const char* key, std::string& value, const std::vector<std::string>&, const char*) { dict[key] = value; }
  template <typename Struct>
  void group(const char* key, Struct& value, const char*) {
    DictWriter inner;
    value.visit(inner);
    dict[key] = inner.dict;
  }
};

template <typename Struct>
py::dict asDict(Struct value) {
  DictWriter writer;
  value.visit(writer);
  return writer.dict;
}

}  // namespace seater_python
