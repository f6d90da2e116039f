// Draws markers by itself, for tests: the camera equations are written out here; the bits come from the family, which
// marker_family_test compares with OpenCV's.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdlib>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "seater_perception/dock_detector.h"

namespace scene {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Whether every value of the tests is asked for: `./seater test --all` sets SEATER_EXTENSIVE.
inline bool extensive() {
  return std::getenv("SEATER_EXTENSIVE") != nullptr;
}

struct Print {
  int id;
  double size;
  Isometry3d T_optical_marker;
};

struct Look {
  double blur = 0.7;   // [px] standard deviation of the lens
  double noise = 2.0;  // [grey levels] standard deviation
  double black = 40.0, white = 215.0, wall = 170.0;
};

seater_perception::Calibration calibration(double f = 640.0, int width = 1280, int height = 720);

/// A marker that stands upright in front of a level camera: `yaw` about the vertical, then looked at with `pitch`,
/// `roll`.
Isometry3d upright(const Vector3d& position, double yaw, double pitch = 0.0, double roll = 0.0);

/// The dock, seen by a level camera at the default place on a chair that stands at (x, y, heading) in the dock frame.
Isometry3d dockSeenFrom(double x, double y, double heading);

seater_perception::DockLayout defaultDock();

/// The places of the default dock's prints, written out: on the wall x = 0.9 looking along -x; print's right is the
/// dock's -y.
std::vector<Print> defaultPrints(const Isometry3d& T_optical_dock);

/// Pixel of a point, by OpenCV.
Vector2d pixelOf(const seater_perception::Calibration& c, const Vector3d& p);

/// Rays (x/z, y/z) of pixels, by OpenCV.
std::vector<cv::Point2d> raysOf(const seater_perception::Calibration& c, const std::vector<cv::Point2d>& pixels);

std::array<Vector2d, 4> trueCorners(const seater_perception::Calibration& c, const Print& print);

/// A print's cells, one pixel each.
cv::Mat cellsOf(const seater_perception::MarkerPattern& pattern);

/// One image of the prints before a wall, blurred and with noise.
cv::Mat draw(const seater_perception::Calibration& c, const seater_perception::MarkerFamily& family,
             const std::vector<Print>& prints, const Look& look, unsigned seed);

cv::Mat draw(const seater_perception::Calibration& c, const std::string& dictionary, const std::vector<Print>& prints,
             const Look& look, unsigned seed);

}  // namespace scene
