// Plain markers have to be found and believed.

#include <gtest/gtest.h>

#include "scene.h"
#include "seater_perception/marker_pose.h"

using namespace seater_perception;

// Near the exactly frontal square, where a tilt is the square root of rounding errors (1e-8), OpenCV's solutions are
// wrong.
TEST(SquareSolutions, areRightForEveryTurnOfAFrontalSquare) {
  const Calibration c = scene::calibration();
  const CameraModel camera = CameraModel::raw(c);
  for (const double roll : {0.0, 0.3, 0.5 * M_PI, 2.0, M_PI, -0.5 * M_PI, -0.25 * M_PI}) {
    for (const double yaw : {0.0, 1e-7, 0.4}) {
      for (const double x : {0.0, -0.0666666666666667}) {
        const scene::Print print{3, 0.1, scene::upright({x, 0.0, 0.533333333333333}, yaw, 0.0, roll)};
        MarkerCorners seen;
        seen.corners = scene::trueCorners(c, print);
        const auto points = markerCorrespondences(camera, seen, print.size, PoseParameters());
        ASSERT_TRUE(points);
        double nearest = 1e9;
        for (const auto& pose : squareSolutions(*points)) {
          nearest = std::min(nearest, (pose.matrix() - print.T_optical_marker.matrix()).cwiseAbs().maxCoeff());
        }
        EXPECT_LT(nearest, 3e-4) << "roll " << roll << ", yaw " << yaw << ", x " << x;
        EXPECT_TRUE(estimateMarker(camera, seen, print.size, PosePrior(), PoseParameters()));
      }
    }
  }
}
