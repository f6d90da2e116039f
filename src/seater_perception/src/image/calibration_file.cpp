#include <algorithm>

#include "seater_perception/camera_model.h"
#include "seater_perception/errors.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

/// The `data` list of one of the matrices; `length` 0 takes any.
std::vector<double> readMatrix(StrictReader& file, const char* key, std::size_t length, const std::string& path,
                               std::vector<std::string>& problems) {
  std::vector<double> values(length, 0.0);
  const YAML::Node node = file.take(key, "a matrix with rows, cols, data", "px");
  if (!node.IsDefined()) return values;
  StrictReader matrix(node, path + ": " + key, problems);
  if (length == 0 && node.IsMap() && node["data"].IsDefined()) length = node["data"].size();
  matrix.numbers("data", values, length, "", "its entries, row by row");
  return values;
}

}  // namespace

Calibration loadCalibration(const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::Exception& error) {
    throw ConfigurationError(path + ": cannot be read as YAML: " + error.what());
  }
  std::vector<std::string> problems;
  StrictReader file(root, path, problems);
  Calibration c;
  file.integer("image_width", c.width, "px", 1, 100000, "width of the image");
  file.integer("image_height", c.height, "px", 1, 100000, "height of the image");
  const auto K = readMatrix(file, "camera_matrix", 9, path, problems);
  c.D = readMatrix(file, "distortion_coefficients", 0, path, problems);
  file.choice("distortion_model", c.distortion_model, {"plumb_bob", "rational_polynomial"}, "lens model");
  const auto P = readMatrix(file, "projection_matrix", 12, path, problems);
  throwProblems(problems, "wrong calibration file:");
  std::copy(K.begin(), K.end(), c.K.begin());
  std::copy(P.begin(), P.end(), c.P.begin());
  return c;
}

}  // namespace seater_perception
