#include "seater_perception/camera_model.h"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/calib3d.hpp>

#include "scene.h"
#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

/// `coefficients`: as many of the 14 of OpenCV's model, the last two of which tilt the sensor.
Calibration distorted(const std::string& model, std::size_t coefficients) {
  const std::vector<double> D = {-0.21, 0.12,  0.001,  -0.0015, -0.03,  0.05, -0.02,
                                 0.01,  0.002, -0.003, 0.001,   0.0015, 0.03, -0.02};
  Calibration c = scene::calibration(700.0);
  c.K = {702.0, 0, 641.3, 0, 698.0, 355.2, 0, 0, 1};
  c.distortion_model = model;
  c.D.assign(D.begin(), D.begin() + static_cast<std::ptrdiff_t>(coefficients));
  return c;
}

Calibration fisheye(const std::vector<double>& D) {
  Calibration c = distorted("equidistant", 0);
  c.D = D;
  return c;
}

Eigen::Vector2d fisheyePixel(const Calibration& c, const Eigen::Vector3d& p) {
  const cv::Mat K(3, 3, CV_64F, const_cast<double*>(c.K.data()));
  std::vector<cv::Point2d> pixel;
  cv::fisheye::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, pixel, cv::Vec3d(), cv::Vec3d(), K, c.D);
  return {pixel[0].x, pixel[0].y};
}

const std::vector<std::pair<const char*, std::size_t>> kLenses = {
    {"plumb_bob", 4},           {"plumb_bob", 5},           {"rational_polynomial", 4},
    {"rational_polynomial", 5}, {"rational_polynomial", 8}, {"rational_polynomial", 12},
    {"rational_polynomial", 14}};

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
  for (const auto& [model, coefficients] : kLenses) {
    const Calibration c = distorted(model, coefficients);
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

// Up to 83 degrees from the axis; the four coefficients of the second lens are a 180 degree lens' typical ones.
TEST(CameraModel, fisheyeIsOpenCvs) {
  for (const std::vector<double>& D : {std::vector<double>(4, 0.0), {-0.02, 0.008, -0.006, 0.001}}) {
    const Calibration c = fisheye(D);
    const CameraModel camera = CameraModel::raw(c);
    for (double angle = 0.0; angle < 1.46; angle += 0.145) {
      for (double around = 0.0; around < 6.2; around += 0.7) {
        const Eigen::Vector2d ray = std::tan(angle) * Eigen::Vector2d(std::cos(around), std::sin(around));
        const Eigen::Vector2d expected = fisheyePixel(c, {2.0 * ray.x(), 2.0 * ray.y(), 2.0});
        EXPECT_LT((*camera.project({2.0 * ray.x(), 2.0 * ray.y(), 2.0}) - expected).norm(), 1e-9) << angle;
        const auto back = camera.undistort(expected);
        ASSERT_TRUE(back) << angle;
        EXPECT_LT((*back - ray).norm(), 1e-8 * (1.0 + ray.squaredNorm())) << angle;
      }
    }
  }
  // Without coefficients' help, the radius is f times the angle.
  EXPECT_NEAR(CameraModel::raw(fisheye({0, 0, 0, 0})).project({2.0, 0.0, 2.0})->x(), 641.3 + 702.0 * M_PI / 4.0, 1e-9);
}

TEST(CameraModel, fisheyeHasNoRayFarOut) {
  const CameraModel straight = CameraModel::raw(fisheye({0, 0, 0, 0}));
  EXPECT_TRUE(straight.undistort({641.3 + 702.0 * 1.49, 355.2}));
  EXPECT_FALSE(straight.undistort({641.3 + 702.0 * 1.51, 355.2}));
  EXPECT_FALSE(straight.undistort({641.3 - 702.0 * 4.0, 355.2}));
  // theta (1 - 0.3 theta^2) never exceeds 0.703.
  const CameraModel folding = CameraModel::raw(fisheye({-0.3, 0, 0, 0}));
  EXPECT_TRUE(folding.undistort({641.3 + 702.0 * 0.65, 355.2}));
  EXPECT_FALSE(folding.undistort({641.3 + 702.0 * 0.75, 355.2}));
}

TEST(CameraModel, jacobianIsTheDerivative) {
  std::vector<Calibration> cameras = {fisheye({-0.02, 0.008, -0.006, 0.001})};
  for (const auto& [model, coefficients] : kLenses) cameras.push_back(distorted(model, coefficients));
  for (const Calibration& c : cameras) {
    const CameraModel camera = CameraModel::raw(c);
    const Eigen::Vector3d point(0.5, -0.3, 1.4);
    const auto J = camera.projectionJacobian(point);
    const double h = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(i);
      const Eigen::Vector2d numeric = (*camera.project(point + d) - *camera.project(point - d)) / (2.0 * h);
      EXPECT_LT((J.col(i) - numeric).norm(), 1e-6 * numeric.norm() + 1e-5) << c.distortion_model << c.D.size();
    }
  }
}

// As realsense-ros, realsense-viewer's bags and pyrealsense2 name their lenses.
TEST(CameraModel, namesWithoutCoefficientsMeanNoDistortion) {
  const Eigen::Vector3d point(0.5, -0.3, 1.4);
  const Eigen::Vector2d straight = *CameraModel::raw(scene::calibration()).project(point);
  for (const char* name : {"", "plumb_bob", "rational_polynomial", "Inverse Brown Conrady", "Brown Conrady", "None",
                           "Modified Brown Conrady", "distortion.inverse_brown_conrady"}) {
    for (const std::size_t length : {0, 5}) {
      Calibration c = scene::calibration();
      c.distortion_model = name;
      c.D.assign(length, 0.0);
      EXPECT_EQ(complaint(c), "") << name;
      EXPECT_EQ((*CameraModel::raw(c).project(point) - straight).norm(), 0.0) << name;
      c.D.assign(5, 0.01);
      const bool known = c.distortion_model == "plumb_bob" || c.distortion_model == "rational_polynomial";
      EXPECT_EQ(complaint(c).empty(), known) << name;
    }
  }
  Calibration c = scene::calibration();
  c.distortion_model = "Inverse Brown Conrady";
  c.D = {0.1, 0, 0, 0, 0};
  EXPECT_NE(complaint(c).find("'Inverse Brown Conrady' with coefficients other than 0"), std::string::npos);
  for (const char* listed : {"plumb_bob (4 or 5", "rational_polynomial (4, 5, 8, 12 or 14", "equidistant (4"}) {
    EXPECT_NE(complaint(c).find(listed), std::string::npos) << complaint(c);
  }
  c.distortion_model = "Ftheta";
  c.D.assign(5, 0.0);
  EXPECT_NE(complaint(c).find("'Ftheta', must be"), std::string::npos) << "all 0 is not no distortion with each name";
}

TEST(CameraModel, rectifiedImageUsesPAndNoDistortion) {
  Calibration c = distorted("plumb_bob", 5);
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
  for (const std::size_t length : {1, 3, 8}) {
    c = distorted("plumb_bob", length);
    EXPECT_NE(complaint(c).find("D has " + std::to_string(length) + " coefficients, must have 4 or 5"),
              std::string::npos);
  }
  for (const std::size_t length : {0, 5, 8}) {
    c = distorted("equidistant", length);
    EXPECT_NE(complaint(c).find("must have 4 for equidistant"), std::string::npos);
    EXPECT_EQ(complaint(c, true), "") << "a rectified image has no distortion";
  }
  EXPECT_EQ(complaint(fisheye({0.01, 0.0, 0.0, 0.0, 0.0})), "") << "realsense-ros sends a fifth one, 0";
  c = distorted("fisheye", 4);
  EXPECT_NE(complaint(c).find("distortion_model is 'fisheye', must be plumb_bob"), std::string::npos);
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
