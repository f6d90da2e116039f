// A marker that is printed twice: nothing tells which one is meant.

#include <gtest/gtest.h>

#include "scene.h"
#include "seater_perception/dock_tracker.h"

using namespace seater_perception;

namespace {

/// The default dock, marker 1 of which stands once more below its own place.
std::vector<scene::Print> printsWithCopy(const Eigen::Isometry3d& T_optical_dock) {
  std::vector<scene::Print> prints = scene::defaultPrints(T_optical_dock);
  scene::Print copy = prints[1];
  copy.T_optical_marker.translation() += T_optical_dock.linear() * Eigen::Vector3d(0.0, 0.0, -0.3);
  prints.push_back(copy);
  return prints;
}

/// Both prints of marker 1 are listed where they are; the dock is of the others.
void expectApart(const DetectionResult& result, const Calibration& c, const std::vector<scene::Print>& prints,
                 const Eigen::Isometry3d& T_optical_dock) {
  ASSERT_EQ(result.markers.size(), 2u);
  EXPECT_EQ(result.markers[0].id, 0);
  EXPECT_EQ(result.markers[1].id, 2);
  ASSERT_EQ(result.dock.size(), 1u);
  EXPECT_EQ(result.dock[0].marker_ids, (std::vector<int>{0, 2}));
  EXPECT_LT((result.dock[0].pose.translation() - T_optical_dock.translation()).norm(), 0.01);
  ASSERT_EQ(result.repeated.size(), 2u);
  for (const std::size_t print : {1, 3}) {
    const auto truth = scene::trueCorners(c, prints[print]);
    double nearest = 1e9;
    for (const PlainMarker& marker : result.repeated) {
      EXPECT_EQ(marker.id, 1);
      double worst = 0.0;
      for (std::size_t k = 0; k < 4; ++k) worst = std::max(worst, (marker.corners[k] - truth[k]).norm());
      nearest = std::min(nearest, worst);
    }
    EXPECT_LT(nearest, 0.1) << "print " << print;  // measured 0.03
  }
}

}  // namespace

TEST(RepeatedMarkers, areListedAndNotUsed) {
  const Calibration c = scene::calibration();
  const Eigen::Isometry3d T_optical_dock = scene::dockSeenFrom(-0.6, 0.05, 0.03);
  const auto prints = printsWithCopy(T_optical_dock);
  const cv::Mat image = scene::draw(c, "DICT_4X4_50", prints, scene::Look(), 1);
  PerceptionParameters parameters;
  for (const char* search : {"own", "opencv"}) {
    parameters.detector.search = search;
    DockDetector detector(CameraModel::raw(c), scene::defaultDock(), parameters, CameraMount());
    expectApart(detector.detect(image), c, prints, T_optical_dock);
    DockTracker tracker(CameraModel::raw(c), scene::defaultDock(), parameters, CameraMount());
    expectApart(tracker.detect(image), c, prints, T_optical_dock);
  }
}
