#include <algorithm>

#include "seater_perception/camera_model.h"
#include "seater_perception/errors.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

using Names = std::vector<const char*>;

// The first is camera_calibration's and of OpenCV's sample `calibration`; the others are those of OpenCV's tutorials.
const Names kMatrix = {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K"};
const Names kDistortion = {"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"};
const Names kWidth = {"image_width", "image_Width"}, kHeight = {"image_height", "image_Height"};

/// The name that the file has; the first one, which is then said to be missing, when it has none.
const char* nameIn(const YAML::Node& root, const Names& names) {
  const auto known = [&](const char* name) { return root.IsMap() && root[name].IsDefined(); };
  const auto found = std::find_if(names.begin(), names.end(), known);
  return found != names.end() ? *found : names.front();
}

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

/// By its name; a file that names none is OpenCV's, whose number of coefficients tells.
std::string readModel(StrictReader& file, const YAML::Node& root, std::size_t coefficients) {
  if (!root.IsMap()) return "";
  std::string model;
  if (root["distortion_model"].IsDefined()) {
    file.text("distortion_model", model, "lens model");
    return model;
  }
  int fisheye = 0;  // of OpenCV's sample
  if (root["fisheye_model"].IsDefined()) file.integer("fisheye_model", fisheye, "", 0, 1, "fisheye lens");
  return opencvModel(coefficients, fisheye == 1);
}

}  // namespace

Calibration loadCalibration(const std::string& path) {
  const YAML::Node root = loadYamlFile(path);
  std::vector<std::string> problems;
  StrictReader file(root, path, problems);
  Calibration c;
  file.integer(nameIn(root, kWidth), c.width, "px", 1, 100000, "width of the image");
  file.integer(nameIn(root, kHeight), c.height, "px", 1, 100000, "height of the image");
  const auto K = readMatrix(file, nameIn(root, kMatrix), 9, path, problems);
  c.D = readMatrix(file, nameIn(root, kDistortion), 0, path, problems);
  c.distortion_model = readModel(file, root, c.D.size());
  try {
    Lens(c.distortion_model, c.D);
  } catch (const CalibrationError& error) {
    problems.push_back(path + ": " + error.what());
  }
  std::vector<double> P(12, 0.0);
  if (root.IsMap() && root["projection_matrix"].IsDefined())
    P = readMatrix(file, "projection_matrix", 12, path, problems);
  throwProblems(problems, "wrong calibration file:");
  std::copy(K.begin(), K.end(), c.K.begin());
  std::copy(P.begin(), P.end(), c.P.begin());
  return c;
}

}  // namespace seater_perception
