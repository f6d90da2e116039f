#include <gtest/gtest.h>

#include <fstream>

#include "scene.h"
#include "seater_perception/camera_model.h"
#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

/// A camera with a lens of so many coefficients, of which nothing rectified is known.
Calibration withLens(const std::string& model, std::size_t coefficients) {
  Calibration c = scene::calibration(700.0);
  c.distortion_model = model;
  c.D.clear();
  for (std::size_t i = 0; i < coefficients; ++i) c.D.push_back(0.125 / static_cast<double>(i + 1) - 0.0625);
  c.P.fill(0.0);
  return c;
}

/// As OpenCV's FileStorage writes it.
std::string opencvFile(const Calibration& c, bool as_column, int fisheye) {
  const std::string path = testing::TempDir() + "seater_camera.yml";
  cv::FileStorage file(path, cv::FileStorage::WRITE);
  file << "calibration_time"
       << "Thu 01 Jan 2026 10:00:00"
       << "image_width" << c.width << "image_height" << c.height;
  file << "camera_matrix" << cv::Mat(3, 3, CV_64F, const_cast<double*>(c.K.data()));
  const cv::Mat D(c.D, true);
  file << "distortion_coefficients" << (as_column ? D : cv::Mat(D.t()));
  if (fisheye >= 0) file << "fisheye_model" << fisheye;
  return path;
}

}  // namespace

TEST(CalibrationFile, readsTheDefaultCamera) {
  const Calibration c = loadCalibration(SEATER_CONFIG_DIR "/cameras/d455.yaml");
  EXPECT_EQ(c.width, 1280);
  EXPECT_EQ(c.height, 720);
  EXPECT_EQ(c.K, scene::calibration().K);
  EXPECT_EQ(c.P, scene::calibration().P);
  EXPECT_EQ(c.D.size(), 5u);
}

TEST(CalibrationFile, namesWhatIsMissing) {
  const std::string path = testing::TempDir() + "seater_camera.yaml";
  std::ofstream(path) << "image_width: 640\ncamera_matrix: {data: [1, 2]}\ndistortion_model: fisheye\n";
  try {
    loadCalibration(path);
    FAIL();
  } catch (const ConfigurationError& error) {
    const std::string text = error.what();
    for (const char* part : {"image_height: is missing", "camera_matrix/data", "list of 9",
                             "distortion_coefficients: is missing", "distortion_model is 'fisheye'"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " not in\n" << text;
    }
  }
  EXPECT_THROW(loadCalibration("/nowhere.yaml"), ConfigurationError);
}

TEST(CalibrationFile, readsOpenCvs) {
  for (const std::size_t coefficients : {4, 5, 8, 14}) {
    const Calibration c = withLens(coefficients <= 5 ? "plumb_bob" : "rational_polynomial", coefficients);
    EXPECT_EQ(loadCalibration(opencvFile(c, coefficients == 5, coefficients == 5 ? 0 : -1)), c) << coefficients;
  }
  const Calibration c = withLens("equidistant", 4);
  const Calibration read = loadCalibration(opencvFile(c, true, 1));
  EXPECT_EQ(read, c);
  EXPECT_THROW(CameraModel::rectified(read), CalibrationError) << "nothing is known of rectified images";
}

TEST(CalibrationFile, rawImagesNeedNoProjectionMatrix) {
  const std::string path = testing::TempDir() + "seater_camera_raw.yaml";
  std::ofstream(path)
      << "image_width: 640\nimage_height: 480\ncameraMatrix: {data: [600, 0, 320, 0, 601, 240, 0, 0, 1]}\n"
      << "distCoeffs: {data: [0.1, 0, 0, 0]}\n";
  const CameraModel camera = CameraModel::raw(loadCalibration(path));
  EXPECT_EQ(camera.fy(), 601.0);
  EXPECT_EQ(camera.width(), 640);
}
