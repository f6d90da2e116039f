// Images that others published, with their corners and poses. Skipped with a message where they are not installed.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "pose/marker_pose.h"
#include "scene.h"
#include "search/marker_detector.h"

using namespace seater_perception;
using Corners = std::array<Eigen::Vector2d, 4>;

namespace {

const char* const kAprilTags = "/usr/share/visp-images-data/ViSP-images/AprilTag/benchmark/640x480/";

std::string sharedFolder() {
  const char* given = std::getenv("SEATER_SHARED_DIR");
  return given ? given : SEATER_SHARED_DIR;
}

/// Corners in the file's order, in this package's convention. The files count pixel edges (the image's corner is 0,
/// 0): its coordinates are 0.5 larger than ours, in corners and principal point alike.
std::map<int, Corners> readCorners(const std::string& path) {
  std::map<int, Corners> all;
  std::ifstream file(path);
  for (int id; file >> id;) {
    for (auto& corner : all[id]) {
      file >> corner.x() >> corner.y();
      corner -= Eigen::Vector2d(0.5, 0.5);
    }
  }
  return all;
}

Eigen::Isometry3d readPose(const std::string& path) {
  Eigen::Isometry3d T;
  std::ifstream file(path);
  for (int i = 0; i < 16; ++i) file >> T.matrix()(i / 4, i % 4);
  return T;
}

}  // namespace

class AprilTags : public testing::TestWithParam<std::tuple<const char*, const char*, int>> {};

// The tags' frames are turned by half a turn about the normal against OpenCV's dictionaries, and their corners run
// anticlockwise: ours 0, 1, 2, 3 are theirs 1, 0, 3, 2. Their black squares are 0.25 m x cells / (cells + 2), tags 3
// and 4 half of it: the print with its white margin has 0.25 m. Their poses and corners disagree with each other by up
// to 0.35 px.
TEST_P(AprilTags, cornersAndPosesAreThePublishedOnes) {
  const auto [family, dictionary, cells] = GetParam();
  const std::string folder = kAprilTags;
  const cv::Mat image = cv::imread(folder + "tag" + family + "_640x480.png", cv::IMREAD_GRAYSCALE);
  if (image.empty()) GTEST_SKIP() << "Debian's package visp-images-data is not installed (" << folder << ")";
  const auto published = readCorners(folder + "corners_tag" + family + ".txt");
  ASSERT_EQ(published.size(), 5u);
  Calibration c =
      scene::calibration(700.0, 640, 480);  // principal point (320, 240) in their convention, (319.5, 239.5) in ours

  double worst_corner = 0.0, worst_range = 0.0, worst_direction = 0.0, worst_turn = 0.0;
  for (const bool half : {false, true}) {
    const double size = 0.25 * cells / (cells + 2.0) * (half ? 0.5 : 1.0);
    DockDetector detector(CameraModel::raw(c), layoutOfEqualMarkers(dictionary, size), PerceptionParameters(),
                          CameraMount());
    const auto result = detector.detect(image);
    ASSERT_EQ(result.markers.size(), 5u);
    for (const DetectedMarker& m : result.markers) {
      if ((m.id >= 3) != half) continue;
      ASSERT_TRUE(published.count(m.id));
      const std::size_t theirs[] = {1, 0, 3, 2};
      for (std::size_t i = 0; i < 4; ++i) {
        const double gap = (m.corners[i] - published.at(m.id)[theirs[i]]).norm();
        EXPECT_LT(gap, 0.5) << "tag " << m.id << " corner " << i;
        worst_corner = std::max(worst_corner, gap);
      }
      const Eigen::Isometry3d T = readPose(folder + "cMo_" + std::to_string(m.id) + ".txt");
      const Eigen::Isometry3d ours = m.best().pose * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ());
      const double range = std::abs(ours.translation().norm() / T.translation().norm() - 1.0);
      const double direction = std::acos(ours.translation().normalized().dot(T.translation().normalized())) * 57.3;
      const double turn = Eigen::AngleAxisd(ours.linear().transpose() * T.linear()).angle() * 57.3;
      EXPECT_LT(range, 0.012) << "tag " << m.id;
      EXPECT_LT(direction, 0.06) << "tag " << m.id;
      EXPECT_LT(turn, 1.0) << "tag " << m.id;
      worst_range = std::max(worst_range, range);
      worst_direction = std::max(worst_direction, direction);
      worst_turn = std::max(worst_turn, turn);
    }
  }
  std::printf("  %s: worst corner %.3f px, range %.2f %%, direction %.3f deg, rotation %.2f deg\n", family,
              worst_corner, 100.0 * worst_range, worst_direction, worst_turn);
}

INSTANTIATE_TEST_SUITE_P(Families, AprilTags,
                         testing::Values(std::make_tuple("16_05", "DICT_APRILTAG_16h5", 6),
                                         std::make_tuple("25_09", "DICT_APRILTAG_25h9", 7),
                                         std::make_tuple("36_11", "DICT_APRILTAG_36h11", 8)));

// Squares in a painting, and people: one square of 24 px with a light patch was taken for id 17 of DICT_4X4_50.
TEST(Paintings, showNoMarkers) {
  for (const char* name : {"Klimt/Klimt.pgm", "Solvay/Solvay_conference_1927_Version2_640x440.jpg"}) {
    const std::string path = std::string("/usr/share/visp-images-data/ViSP-images/") + name;
    const cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (image.empty()) GTEST_SKIP() << "Debian's package visp-images-data is not installed (" << path << ")";
    for (const char* family : {"DICT_4X4_50", "DICT_6X6_250"}) {
      const MarkerDetector detector(MarkerFamily::named(family), DetectorParameters());
      EXPECT_TRUE(detector.detect(image).markers.empty()) << path << ", " << family;
    }
  }
}

TEST(Photograph, cornersAreThePublishedOnes) {
  const std::string path = sharedFolder() + "/data/real_aruco/tag_01_d7_14cm.png";
  const cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (image.empty()) GTEST_SKIP() << "the photograph is not there: " << path << " (folder: SEATER_SHARED_DIR)";
  Calibration c;
  c.width = 1280;
  c.height = 960;
  c.K = {1006.126285753055, 0, 655.8639244150409, 0, 1004.015433012594, 490.6140221242933, 0, 0, 1};
  c.D = {0.1349735087283542, -0.2335869827451621, 0.0006697030315075139, 0.004846737465872353, 0};
  c.distortion_model = "plumb_bob";
  DockDetector detector(CameraModel::raw(c), layoutOfEqualMarkers("DICT_5X5_1000", 0.145), PerceptionParameters(),
                        CameraMount());
  const auto result = detector.detect(image);
  ASSERT_EQ(result.markers.size(), 1u);
  const DetectedMarker& marker = result.markers[0];
  EXPECT_EQ(marker.id, 1);
  using V = Eigen::Vector2d;
  const Corners published = {V(569.899, 201.559), V(777.426, 206.850), V(767.959, 415.378), V(565.753, 409.245)};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((marker.corners[i] - published[i]).norm(), 0.5) << i;
  const Eigen::Vector3d t = marker.best().pose.translation();
  std::printf("  position %.4f %.4f %.4f m, reprojection error %.3f px, sigma of range %.2f mm\n", t.x(), t.y(), t.z(),
              marker.best().error, 1e3 * std::sqrt(marker.best().covariance(2, 2)));
  // The pose that the published corners give; half a pixel on the 207 px side is 0.25 % of the range.
  MarkerCorners theirs;
  theirs.corners = published;
  const auto reference = estimateMarker(detector.camera(), theirs, 0.145, PosePrior(), PoseParameters());
  ASSERT_TRUE(reference);
  EXPECT_LT((t - reference->best().pose.translation()).norm(), 0.0025 * t.norm());
}
