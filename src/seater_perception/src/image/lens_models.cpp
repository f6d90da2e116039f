// Which lens models there are, by name and number of coefficients.

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>

#include "seater_perception/camera_model.h"
#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

struct Model {
  const char* name;
  std::vector<std::size_t> lengths;  // of D
};

const std::vector<Model>& models() {
  static const std::vector<Model> list = {
      {"plumb_bob", {4, 5}}, {"rational_polynomial", {4, 5, 8, 12, 14}}, {"equidistant", {4}}};
  return list;
}

std::string joined(const std::vector<std::size_t>& lengths) {
  std::string text;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const char* const between = i == 0 ? "" : i + 1 == lengths.size() ? " or " : ", ";
    text += between + std::to_string(lengths[i]);
  }
  return text;
}

std::string supported() {
  std::string text;
  for (const Model& m : models()) text += std::string(m.name) + " (" + joined(m.lengths) + " coefficients), ";
  return text + "or without distortion (all coefficients 0) none, brown_conrady, inverse_brown_conrady, " +
         "modified_brown_conrady";
}

/// librealsense writes its models' names as "Inverse Brown Conrady" or "distortion.inverse_brown_conrady".
bool isRealSense(std::string name) {
  const std::string prefix = "distortion.";
  if (name.rfind(prefix, 0) == 0) name.erase(0, prefix.size());
  for (char& c : name) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return std::set<std::string>{"none", "brown_conrady", "inverse_brown_conrady", "modified_brown_conrady"}.count(name);
}

void requireFinite(const std::vector<double>& D) {
  for (std::size_t i = 0; i < D.size(); ++i) {
    if (std::isfinite(D[i])) continue;
    std::ostringstream text;
    text << "D[" << i << "] is " << D[i] << ", must be finite";
    throw CalibrationError(text.str());
  }
}

const Model& modelOf(const std::string& name) {
  for (const Model& known : models()) {
    if (name == known.name) return known;
  }
  const std::string why = isRealSense(name) ? "with coefficients other than 0, which is not supported" : "";
  throw CalibrationError("distortion_model is '" + name + "'" + (why.empty() ? "" : " " + why) + ", must be " +
                         supported());
}

/// From the plane z = 1 to a sensor turned about x, then y: OpenCV's matrix of the Scheimpflug model.
Eigen::Matrix3d tiltOf(double tau_x, double tau_y) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(tau_y, -Eigen::Vector3d::UnitY().eval()) *
                             Eigen::AngleAxisd(tau_x, -Eigen::Vector3d::UnitX().eval()))
                                .toRotationMatrix();
  Eigen::Matrix3d along_z;
  along_z << R(2, 2), 0.0, -R(0, 2), 0.0, R(2, 2), -R(1, 2), 0.0, 0.0, 1.0;
  return along_z * R;
}

}  // namespace

std::string opencvModel(std::size_t coefficients, bool fisheye) {
  if (fisheye) return "equidistant";
  return coefficients <= 5 ? "plumb_bob" : "rational_polynomial";
}

Lens::Lens(const std::string& model, const std::vector<double>& D) {
  requireFinite(D);
  const bool straight = std::all_of(D.begin(), D.end(), [](double k) { return k == 0.0; });
  if (straight && (model.empty() || isRealSense(model))) return;
  const Model& known = modelOf(model);
  const bool fisheye = model == "equidistant";
  if (straight && !fisheye) return;
  std::vector<double> d = D;
  // realsense-ros sends five coefficients of a fisheye camera, the last one unused.
  if (fisheye && d.size() == 5 && d.back() == 0.0) d.pop_back();
  if (std::find(known.lengths.begin(), known.lengths.end(), d.size()) == known.lengths.end()) {
    throw CalibrationError("D has " + std::to_string(D.size()) + " coefficients, must have " + joined(known.lengths) +
                           " for " + model);
  }
  if (fisheye) kind_ = Kind::fisheye;
  if (d.size() == 14 && (d[12] != 0.0 || d[13] != 0.0)) {
    kind_ = Kind::tilted;
    tilt_ = tiltOf(d[12], d[13]);
  }
  std::copy_n(d.begin(), std::min(d.size(), d_.size()), d_.begin());
}

}  // namespace seater_perception
