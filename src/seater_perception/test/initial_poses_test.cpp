// Both poses under which a marker looks nearly the same.

#include "stage/initial_poses.h"

#include <gtest/gtest.h>

#include "scene.h"
#include "seater_perception/dock_layout.h"

using namespace seater_perception;

namespace {

/// Facing the camera from 3 m, aside of its axis, turned by yaw and pitch [rad].
Eigen::Isometry3d farMarker(double yaw, double pitch) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()))
          .toRotationMatrix() *
      Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  pose.translation() = Eigen::Vector3d(0.4, -0.2, 3.0);
  return pose;
}

double tilt(const Eigen::Isometry3d& pose) {
  return std::acos(-pose.translation().normalized().dot(pose.linear().col(2)));
}

MarkerEstimate smallMarker() {
  MarkerEstimate marker;
  marker.image.corners = {Eigen::Vector2d(0.0, 0.0), {22.0, 0.0}, {22.0, 22.0}, {0.0, 22.0}};
  return marker;
}

}  // namespace

TEST(InitialPoses, MirroredLooksTheSameFromFarAway) {
  const Eigen::Isometry3d pose = farMarker(0.4, 0.1), other = mirrored(pose);
  EXPECT_NEAR(other.linear().determinant(), 1.0, 1e-12);
  EXPECT_TRUE(samePose(mirrored(other), pose));
  EXPECT_NEAR(tilt(other), tilt(pose), 1e-12);
  EXPECT_GT(Eigen::AngleAxisd(other.linear().transpose() * pose.linear()).angle(), 0.4);
  for (const Eigen::Vector3d& corner : markerCorners(0.01)) {  // 2 px at f = 600 px
    EXPECT_LT(600.0 * ((pose * corner).hnormalized() - (other * corner).hnormalized()).norm(), 0.01);
  }
}

TEST(InitialPoses, TiltedIsSteepEnoughAndGoesTheSameWay) {
  const Eigen::Isometry3d flat = farMarker(-std::atan2(0.4, 3.0) + 0.02, 0.07), steep = tilted(flat, 0.3);
  EXPECT_NEAR(tilt(steep), 0.3, 1e-9);
  const Eigen::Vector3d sight = -flat.translation().normalized();
  const auto aside = [&](const Eigen::Isometry3d& pose) {
    const Eigen::Vector3d n = pose.linear().col(2);
    return (n - n.dot(sight) * sight).normalized();
  };
  EXPECT_GT(aside(flat).dot(aside(steep)), 1.0 - 1e-9);
  const Eigen::Isometry3d steeper = farMarker(0.9, 0.0);
  EXPECT_TRUE(samePose(tilted(steeper, 0.3), steeper));
  Eigen::Isometry3d frontal = flat;  // normal exactly towards the camera
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(sight).normalized();
  frontal.linear() << right, sight.cross(right), sight;
  EXPECT_NEAR(tilt(tilted(frontal, 0.3)), 0.3, 1e-6);
}

TEST(InitialPoses, TheOtherBranchIsOpenUntilSomethingDecides) {
  MarkerEstimate marker = smallMarker();
  const std::vector<PoseHypothesis> one(1), two(2);
  std::vector<PhotometricBranch> branches(2);
  EXPECT_TRUE(otherBranchOpen(marker, branches, one));
  EXPECT_FALSE(otherBranchOpen(marker, branches, two));
  branches[1].hopeless = true;
  EXPECT_FALSE(otherBranchOpen(marker, branches, one));
  branches[1].hopeless = false;
  marker.branch_known = true;
  EXPECT_FALSE(otherBranchOpen(marker, branches, one));
  marker.branch_known = false;
  for (auto& corner : marker.image.corners) corner *= 3.0;
  EXPECT_FALSE(otherBranchOpen(marker, branches, one));
}

TEST(InitialPoses, SharpCornersOfALargeMarkerDecide) {
  MarkerEstimate marker = smallMarker();
  for (auto& corner : marker.image.corners) corner *= 3.0;
  marker.image.edges_fitted = true;
  marker.hypotheses.resize(2);
  marker.hypotheses[0].pose = farMarker(0.4, 0.1);
  marker.hypotheses[1].pose = mirrored(marker.hypotheses[0].pose);
  marker.hypotheses[1].chi_squared = 20.0;
  ASSERT_EQ(openPoses(marker).size(), 1u);
  EXPECT_TRUE(samePose(openPoses(marker)[0], marker.hypotheses[0].pose));
  marker.hypotheses[1].chi_squared = 10.0;
  EXPECT_EQ(openPoses(marker).size(), 2u);
  marker.hypotheses[1].chi_squared = 20.0;
  marker.image.edges_fitted = false;
  EXPECT_EQ(openPoses(marker).size(), 2u);
  marker.image.edges_fitted = true;
  for (auto& corner : marker.image.corners) corner /= 3.0;
  EXPECT_EQ(openPoses(marker).size(), 2u);
}

// By grey levels: the image's likelihoods alone, which are the weights where nothing is known of how markers stand.
TEST(InitialPoses, AmbiguityIsTheLikelihoodRatioOfBothBranches) {
  const Calibration camera = scene::calibration();
  DockDetector detector(CameraModel::raw(camera), layoutOfEqualMarkers("DICT_4X4_50", 0.1), PerceptionParameters(),
                        CameraMount());
  int two = 0;
  for (unsigned k = 0; k < 12; ++k) {
    const scene::Print print{3, 0.1, scene::upright({0.02 * k, 0.0, 2.8}, 0.1)};
    const auto result = detector.detect(scene::draw(camera, "DICT_4X4_50", {print}, scene::Look(), k));
    ASSERT_EQ(result.markers.size(), 1u) << k;
    const DetectedMarker& marker = result.markers[0];
    if (marker.hypotheses.size() < 2) {
      EXPECT_EQ(marker.ambiguity, 0.0);
      continue;
    }
    ++two;
    EXPECT_NEAR(marker.ambiguity, marker.hypotheses[1].weight / marker.best().weight, 1e-9);
    EXPECT_LE(marker.ambiguity, 1.0);
  }
  std::printf("  two branches in %d of 12 images\n", two);
  EXPECT_GE(two, 4);
}
