// Fits that begin at the last image's poses: what is expected of a followed marker, and that its results are those of
// a detector that knows no history.

#include "pipeline/expected_marker.h"

#include <gtest/gtest.h>

#include "numerics/solve.h"
#include "scene.h"
#include "seater_perception/dock_tracker.h"

using namespace seater_perception;

namespace {

const Calibration kCamera = scene::calibration();
const CameraModel kModel = CameraModel::raw(kCamera);
constexpr double kSide = 0.1;  // [m]

MarkerCorners seenAt(const Eigen::Isometry3d& pose) {
  MarkerCorners corners;
  corners.corners = scene::trueCorners(kCamera, {0, kSide, pose});
  return corners;
}

/// As the last image left it, with one pose.
MarkerEstimate known(const Eigen::Isometry3d& pose, double rotation_sd = 0.02) {
  MarkerEstimate marker;
  marker.image = seenAt(pose);
  marker.image.psf_sd = 0.9;
  marker.size = kSide;
  marker.hypotheses.resize(1);
  marker.hypotheses[0].pose = pose;
  marker.hypotheses[0].covariance = 1e-6 * Matrix6d::Identity();
  marker.hypotheses[0].covariance.diagonal().tail<3>().setConstant(rotation_sd * rotation_sd / 3.0);
  return marker;
}

double farthestCorner(const Eigen::Isometry3d& pose, const MarkerCorners& seen) {
  double farthest = 0.0;
  const auto corners = seenAt(pose).corners;
  for (std::size_t i = 0; i < 4; ++i) farthest = std::max(farthest, (corners[i] - seen.corners[i]).norm());
  return farthest;
}

double turn(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

cv::Mat drawn(const scene::Print& print, unsigned seed) {
  return scene::draw(kCamera, "DICT_4X4_50", {print}, scene::Look(), seed);
}

const DockLayout kAny = layoutOfEqualMarkers("DICT_4X4_50", kSide);

DockTracker trackerOfAny() {
  PerceptionParameters parameters;
  parameters.tracking.full_search_every = 1000;
  return DockTracker(kModel, kAny, parameters, CameraMount());
}

}  // namespace

TEST(ExpectedMarker, posesFollowTheCorners) {
  for (const double z : {0.35, 1.0, 2.5}) {
    const Eigen::Isometry3d before = scene::upright({0.1 * z, 0.0, z}, 0.5);
    const Eigen::Isometry3d now = scene::upright({0.1 * z + 0.0125 * z, 0.005 * z, 0.99 * z}, 0.51, 0.0, 0.02);
    const MarkerCorners seen = seenAt(now);
    ASSERT_GT(farthestCorner(before, seen), 8.0);
    const auto expected = expectedMarker(kModel, known(before), seen);
    ASSERT_TRUE(expected);
    ASSERT_EQ(expected->hypotheses.size(), 1u) << "0.5 rad are decided";
    EXPECT_LT(farthestCorner(expected->best().pose, seen), 0.1) << z;
    EXPECT_LT(turn(expected->best().pose, now), 0.015) << z;
    EXPECT_EQ(expected->image.psf_sd, 0.9);
  }
}

// A corner that is 0.2 px off turns a marker of 25 px by up to 0.2 rad where only the corners count.
TEST(ExpectedMarker, smallMarkersKeepTheirTilt) {
  const Eigen::Isometry3d pose = scene::upright({0.0, 0.0, 2.5}, 0.4);
  MarkerCorners seen = seenAt(pose);
  seen.corners[0].x() += 0.2;
  seen.corners[2].y() -= 0.2;
  const auto expected = expectedMarker(kModel, known(pose), seen);
  ASSERT_TRUE(expected);
  EXPECT_LT(turn(expected->best().pose, pose), 0.02);
}

TEST(ExpectedMarker, anOpenTiltGetsItsMirrorImage) {
  const Eigen::Isometry3d slight = scene::upright({0.05, 0.02, 2.5}, 0.1);
  const auto open = expectedMarker(kModel, known(slight), seenAt(slight));
  ASSERT_TRUE(open);
  ASSERT_EQ(open->hypotheses.size(), 2u);
  EXPECT_GT(turn(open->hypotheses[0].pose, open->hypotheses[1].pose), 0.1);
  EXPECT_LT(farthestCorner(open->hypotheses[1].pose, open->image), 0.3) << "25 px: the corners do not tell them apart";
  const Eigen::Isometry3d uncertain = scene::upright({0.05, 0.02, 2.5}, 0.4);
  EXPECT_EQ(expectedMarker(kModel, known(uncertain, 0.3), seenAt(uncertain))->hypotheses.size(), 2u);
  EXPECT_EQ(expectedMarker(kModel, known(uncertain), seenAt(uncertain))->hypotheses.size(), 1u);
}

TEST(ExpectedMarker, nothingIsExpectedBehindTheCamera) {
  Eigen::Isometry3d behind = scene::upright({0.0, 0.0, 1.0}, 0.3);
  const MarkerCorners seen = seenAt(behind);
  behind.translation().z() = -1.0;
  MarkerEstimate last = known(scene::upright({0.0, 0.0, 1.0}, 0.3));
  last.hypotheses[0].pose = behind;
  EXPECT_FALSE(expectedMarker(kModel, last, seen));
}

// The same minimum from another beginning: measured at most 0.3 standard deviations (of the noise) apart.
TEST(ExpectedMarker, resultsAreThoseOfADetectorWithoutHistory) {
  DockDetector detector(kModel, kAny, PerceptionParameters(), CameraMount());
  for (const double z : {0.5, 1.0, 2.5}) {
    DockTracker tracker = trackerOfAny();
    double worst = 0.0;
    for (unsigned k = 0; k < 12; ++k) {
      const scene::Print print{
          3, kSide,
          scene::upright({(0.02 + 0.004 * k) * z, 0.0, z * (1.0 - 0.005 * k)}, 0.45 - 0.012 * k, 0.0, 0.01 * k)};
      const cv::Mat image = drawn(print, k);
      const auto followed = tracker.detect(image), alone = detector.detect(image);
      ASSERT_EQ(followed.markers.size(), 1u) << z;
      ASSERT_EQ(alone.markers.size(), 1u) << z;
      EXPECT_EQ(followed.full_search, k == 0);
      const PoseHypothesis &a = followed.markers[0].best(), &b = alone.markers[0].best();
      const auto d = poseDifference(a.pose, b.pose);
      worst = std::max(worst, std::sqrt(d.dot(solved(b.covariance, d))));
    }
    std::printf("  %.1f m: at most %.2f standard deviations apart\n", z, worst);
    EXPECT_LT(worst, 0.7) << z;
  }
}

// Tilted one way, square on, tilted the other way: the track must not stay on the first side.
TEST(ExpectedMarker, changesSidesWithTheMarker) {
  for (const double z : {1.2, 2.5}) {
    DockTracker tracker = trackerOfAny();
    int right = 0, all = 0;
    for (unsigned k = 0; k < 33; ++k) {
      const double yaw = 0.4 - 0.025 * k;
      const Eigen::Isometry3d truth = scene::upright({0.0, 0.0, z}, yaw);
      const auto result = tracker.detect(drawn({4, kSide, truth}, k));
      ASSERT_EQ(result.markers.size(), 1u) << z << ", " << yaw;
      if (std::abs(yaw) < 0.15) continue;
      ++all;
      right += turn(result.markers[0].best().pose, truth) < 0.1;
    }
    EXPECT_EQ(right, all) << z;
  }
}

// Constant motion, then 8 px aside of where it leads.
TEST(ExpectedMarker, aWrongPredictionIsMadeGood) {
  for (const double z : {0.35, 1.0, 2.5}) {
    for (const double angle : {0.0, 1.6, 3.9}) {
      DockTracker tracker = trackerOfAny();
      const double px = z / 640.0;
      for (unsigned k = 0; k < 3; ++k)
        tracker.detect(drawn({5, kSide, scene::upright({4.0 * k * px, 0.0, z}, 0.4)}, k));
      const scene::Print jumped{
          5, kSide, scene::upright({(12.0 + 8.0 * std::cos(angle)) * px, 8.0 * std::sin(angle) * px, z}, 0.4)};
      const auto result = tracker.detect(drawn(jumped, 9));
      ASSERT_EQ(result.markers.size(), 1u) << z;
      EXPECT_FALSE(result.full_search) << z;
      EXPECT_LT((result.markers[0].best().pose.translation() - jumped.T_optical_marker.translation()).norm(),
                0.004 * z);
    }
  }
}

// A blank card, another id, nothing: at three sizes, with a history that knows pose, blur and brightness.
TEST(ExpectedMarker, aHistoryIsNoProof) {
  for (const double z : {0.5, 1.0, 2.5}) {
    const scene::Print print{6, kSide, scene::upright({0.1, 0.0, z}, 0.3)};
    scene::Print other = print;
    other.id = 17;
    cv::Mat card = drawn(print, 20);
    std::vector<cv::Point> outline;
    for (const auto& c : scene::trueCorners(kCamera, print)) outline.emplace_back(cvRound(c.x()), cvRound(c.y()));
    cv::fillConvexPoly(card, outline, cv::Scalar(200));
    for (const cv::Mat& changed :
         {card, drawn(other, 21), scene::draw(kCamera, "DICT_4X4_50", {}, scene::Look(), 22)}) {
      DockTracker tracker = trackerOfAny();
      for (unsigned k = 0; k < 3; ++k) ASSERT_EQ(tracker.detect(drawn(print, k)).markers.size(), 1u);
      for (int again = 0; again < 2; ++again) {
        for (const DetectedMarker& m : tracker.detect(changed).markers) EXPECT_EQ(m.id, 17) << z;
      }
    }
  }
}
