#include "seater_perception/camera_model.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "scene.h"
#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

Calibration distorted(const std::string& model) {
  Calibration c = scene::calibration(700.0);
  c.K = {702.0, 0, 641.3, 0, 698.0, 355.2, 0, 0, 1};
  c.distortion_model = model;
  c.D = {-0.21, 0.12, 0.001, -0.0015, -0.03};
  if (model == "rational_polynomial") c.D.insert(c.D.end(), {0.05, -0.02, 0.01});
  return c;
}

std::string complaint(const Calibration& c, bool rectified = false) {
  try {
    rectified ? CameraModel::rectified(c) : CameraModel::raw(c);
  } catch (const CalibrationError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(CameraModel, pinholeIsTheClosedForm) {
  const CameraModel camera = CameraModel::raw(scene::calibration(640.0));
  const auto pixel = camera.project({0.3, -0.2, 2.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 639.5 + 640.0 * 0.15, 1e-9);
  EXPECT_NEAR(pixel->y(), 359.5 - 640.0 * 0.10, 1e-9);
  EXPECT_FALSE(camera.project({0.0, 0.0, 0.0}));
  EXPECT_FALSE(camera.project({0.1, 0.0, -1.0}));
}

TEST(CameraModel, distortionIsOpenCvs) {
  for (const char* model : {"plumb_bob", "rational_polynomial"}) {
    const Calibration c = distorted(model);
    const CameraModel camera = CameraModel::raw(c);
    for (double x = -0.8; x <= 0.8; x += 0.2) {
      for (double y = -0.4; y <= 0.4; y += 0.2) {
        const Eigen::Vector3d point(2.0 * x, 2.0 * y, 2.0);
        const Eigen::Vector2d expected = scene::pixelOf(c, point);
        EXPECT_LT((*camera.project(point) - expected).norm(), 1e-9) << model << x << " " << y;
        const auto back = camera.undistort(expected);
        ASSERT_TRUE(back) << model << x << " " << y;
        EXPECT_LT((*back - Eigen::Vector2d(x, y)).norm(), 1e-9) << model;
      }
    }
  }
}

TEST(CameraModel, jacobianIsTheDerivative) {
  const CameraModel camera = CameraModel::raw(distorted("rational_polynomial"));
  const Eigen::Vector3d point(0.5, -0.3, 1.4);
  const auto J = camera.projectionJacobian(point);
  const double h = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d numeric = (*camera.project(point + d) - *camera.project(point - d)) / (2.0 * h);
    EXPECT_LT((J.col(i) - numeric).norm(), 1e-4 * numeric.norm() + 1e-5);
  }
}

TEST(CameraModel, rectifiedImageUsesPAndNoDistortion) {
  Calibration c = distorted("plumb_bob");
  c.P = {500, 0, 600, 0, 0, 510, 300, 0, 0, 0, 1, 0};
  const auto pixel = CameraModel::rectified(c).project({0.1, 0.2, 1.0});
  EXPECT_NEAR(pixel->x(), 650.0, 1e-9);
  EXPECT_NEAR(pixel->y(), 402.0, 1e-9);
  EXPECT_GT((*pixel - *CameraModel::raw(c).project({0.1, 0.2, 1.0})).norm(), 10.0);
}

TEST(CameraModel, pixelBeyondTheFoldHasNoRay) {
  Calibration c = scene::calibration();
  c.D = {-0.6, 0, 0, 0, 0};  // r (1 - 0.6 r^2) never exceeds 0.497
  const CameraModel camera = CameraModel::raw(c);
  EXPECT_TRUE(camera.undistort({639.5 + 0.4 * 640.0, 359.5}));
  EXPECT_FALSE(camera.undistort({639.5 + 0.6 * 640.0, 359.5}));
  EXPECT_FALSE(camera.undistort({std::numeric_limits<double>::quiet_NaN(), 0.0}));
}

TEST(CameraModel, refusesWhatIsNoCalibration) {
  const Calibration good = scene::calibration();
  EXPECT_EQ(complaint(good), "");
  Calibration c = good;
  c.K[0] = 0.0;
  EXPECT_NE(complaint(c).find("K[0] (focal length) is 0"), std::string::npos);
  c = good;
  c.K[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(complaint(c).find("K[5] is nan"), std::string::npos);
  for (const std::size_t i : {3, 6, 7, 8}) {
    c = good;
    c.K[i] += 0.5;
    EXPECT_NE(complaint(c).find("K[" + std::to_string(i) + "] is"), std::string::npos) << i;
  }
  c = good;
  c.D[1] = std::numeric_limits<double>::infinity();
  EXPECT_NE(complaint(c).find("D[1] is inf"), std::string::npos);
  c = good;
  c.D.pop_back();
  EXPECT_NE(complaint(c).find("D has 4"), std::string::npos);
  c = good;
  c.distortion_model = "equidistant";
  EXPECT_NE(complaint(c).find("equidistant"), std::string::npos);
  EXPECT_EQ(complaint(c, true), "") << "a rectified image has no distortion";
  c = good;
  c.width = 0;
  EXPECT_NE(complaint(c).find("image size"), std::string::npos);
  c = good;
  c.P[0] = 0.0;
  EXPECT_NE(complaint(c, true).find("P[0]"), std::string::npos);
  c = good;
  c.P[3] = -30.0;
  EXPECT_NE(complaint(c, true).find("P[3]"), std::string::npos);
}

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
    for (const char* part :
         {"image_height: is missing", "camera_matrix/data", "list of 9", "distortion_coefficients: is missing",
          "distortion_model: is fisheye", "projection_matrix: is missing"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " not in\n" << text;
    }
  }
  EXPECT_THROW(loadCalibration("/nowhere.yaml"), ConfigurationError);
}
