// The edge of a shadow across a marker: found, taken away, and the marker read as if it were not there.

#include "search/code/shadow_edge.h"

#include <gtest/gtest.h>

#include "scene.h"
#include "seater_perception/dock_tracker.h"

using namespace seater_perception;

namespace {

const double kBlur = 1.5;  // [px] of the shadow's edge

/// A shadow over all of the image below a line through `p`, at `angle` to the rows [rad].
void shade(cv::Mat& image, const Eigen::Vector2d& p, double angle, double factor) {
  const Eigen::Vector2d normal(-std::sin(angle), std::cos(angle));  // downwards, into the shadow
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double deep = normal.dot(Eigen::Vector2d(u, v) - p) / kBlur;
      const double light = 1.0 - (1.0 - factor) * 0.5 * std::erfc(-deep * M_SQRT1_2);
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(light * image.at<uchar>(v, u));
    }
  }
}

cv::Mat drawn(const scene::Print& print, unsigned seed) {
  scene::Look look;
  look.blur = 1.0;
  return scene::draw(scene::calibration(), "DICT_4X4_50", {print}, look, seed);
}

scene::Print at(double x, double z) {
  return {0, 0.1, scene::upright({x, 0.02, z}, 0.25)};
}

Eigen::Vector2d middle(const scene::Print& print) {
  return scene::pixelOf(scene::calibration(), print.T_optical_marker.translation());
}

DockTracker makeTracker() {
  return DockTracker(CameraModel::raw(scene::calibration()), scene::defaultDock(), PerceptionParameters(),
                     CameraMount());
}

/// Samples of a print's quiet zone under light that falls off across lines x = `at`.
ImageLevels::Samples ring(const PatternGrid& grid, const std::vector<double>& lines, double factor) {
  ImageLevels::Samples samples;
  samples.grey = Eigen::VectorXf::Constant(grid.size(), 40.0F);
  samples.weights = Eigen::VectorXf::Ones(grid.size());
  samples.seen = grid.size();
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column, ++i) {
      if (grid.ring(row, column) > 0) continue;
      int passed = 0;
      for (const double x : lines) passed += grid.x(column) > x;
      samples.grey[i] = static_cast<float>(200.0 * (passed % 2 ? factor : 1.0));
    }
  }
  return samples;
}

const Quad kSquare{{{100.0, 100.0}, {200.0, 100.0}, {200.0, 200.0}, {100.0, 200.0}}};

}  // namespace

TEST(ShadowEdge, isFoundByTheQuietZone) {
  const PatternGrid grid(6);
  const auto shadow = findShadowEdge(grid, ring(grid, {0.2}, 0.5), kSquare);
  ASSERT_TRUE(shadow);
  EXPECT_NEAR(shadow->factor, 0.5, 1e-6);
  EXPECT_NEAR(shadow->normal.x(), -1.0, 0.01);
  EXPECT_NEAR(-shadow->offset, 160.0, 5.0);  // between two samples
  EXPECT_NEAR(shadow->light({110.0, 150.0}), 1.0, 1e-3);
  EXPECT_NEAR(shadow->light({190.0, 150.0}), 0.5, 1e-3);
  cv::Mat grey(300, 300, CV_8U, cv::Scalar(200));
  grey.colRange(160, 300).setTo(100);
  const cv::Mat lit = withoutShadows(grey, {*shadow});
  EXPECT_NEAR(lit.at<uchar>(150, 110), 200, 1);
  EXPECT_NEAR(lit.at<uchar>(150, 190), 200, 1);
  EXPECT_EQ(lit.at<uchar>(150, 299), 100);   // beyond the print
  EXPECT_EQ(grey.at<uchar>(150, 190), 100);  // the image itself stays
}

TEST(ShadowEdge, isTakenAwayOnceWhereRegionsOverlap) {
  ShadowEdge left;  // of 100 x 100 px, all of it deep in the shadow
  left.offset = 1000.0;
  left.factor = 0.5;
  left.region = {0, 0, 100, 100};
  ShadowEdge right = left;
  right.factor = 0.25;
  right.region = {60, 0, 100, 100};
  const cv::Mat grey(100, 200, CV_8U, cv::Scalar(40));
  const cv::Mat lit = withoutShadows(grey, {left, right});
  EXPECT_EQ(lit.at<uchar>(50, 30), 80);
  EXPECT_EQ(lit.at<uchar>(50, 78), 80);  // nearer to the left print
  EXPECT_EQ(lit.at<uchar>(50, 82), 160);
  EXPECT_EQ(lit.at<uchar>(50, 130), 160);
  EXPECT_EQ(lit.at<uchar>(50, 180), 40);
  EXPECT_EQ(withoutShadows(grey, {}).data,
            grey.data);  // nothing to take away: no copy
}

// Prints so near to each other that the regions that are lifted for each reach into the other's.
TEST(ShadowEdge, neighboursAcrossItAreFoundWhereTheyAre) {
  const std::vector<scene::Print> prints{{0, 0.1, scene::upright({-0.07, 0.02, 0.8}, 0.25)},
                                         {1, 0.1, scene::upright({0.07, 0.02, 0.8}, 0.25)}};
  scene::Look look;
  look.blur = 1.0;
  cv::Mat image = scene::draw(scene::calibration(), "DICT_4X4_50", prints, look, 1);
  shade(image, {639.0, 375.0}, 0.1, 0.5);
  DockDetector detector(CameraModel::raw(scene::calibration()), layoutOfEqualMarkers("DICT_4X4_50", 0.1),
                        PerceptionParameters(), CameraMount());
  const auto result = detector.detect(image);
  ASSERT_EQ(result.markers.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d off = result.markers[i].best().pose.translation() - prints[i].T_optical_marker.translation();
    EXPECT_LT(off.norm(), 0.0032) << i;
  }
}

TEST(ShadowEdge, onlyWhereThereIsOne) {
  const PatternGrid grid(6);
  EXPECT_FALSE(findShadowEdge(grid, ring(grid, {}, 0.5), kSquare));
  EXPECT_FALSE(findShadowEdge(grid, ring(grid, {0.2}, 0.95), kSquare));       // too weak
  EXPECT_FALSE(findShadowEdge(grid, ring(grid, {-0.4, 0.4}, 0.5), kSquare));  // a stripe
  EXPECT_FALSE(findShadowEdge(grid, ring(grid, {0.2}, 0.05), kSquare));       // no light at all
  ImageLevels::Samples nothing = ring(grid, {0.2}, 0.5);
  nothing.weights.setZero();
  EXPECT_FALSE(findShadowEdge(grid, nothing, kSquare));
}

TEST(ShadowEdge, aMarkerAcrossItIsFoundWhereItIs) {
  DockDetector detector(CameraModel::raw(scene::calibration()), scene::defaultDock(), PerceptionParameters(),
                        CameraMount());
  for (const double z : {0.5, 1.0, 1.6}) {
    for (const double factor : {0.7, 0.5, 0.35}) {
      if (z > 0.5 && factor < 0.5) continue;  // a strong one grows together with a small marker's border
      for (int k = 0; k < 4; ++k) {
        const scene::Print print = at(0.05, z);
        cv::Mat image = drawn(print, static_cast<unsigned>(k));
        shade(image, middle(print), 0.4 + 0.8 * k, factor);
        const auto result = detector.detect(image);
        ASSERT_EQ(result.markers.size(), 1u) << z << " m, factor " << factor << ", number " << k;
        const Eigen::Vector3d off = result.markers[0].best().pose.translation() - print.T_optical_marker.translation();
        EXPECT_LT(off.norm(), 0.004 * z) << factor << ", number " << k;
        const Matrix6d C = result.markers[0].covariance();
        EXPECT_LT(off.dot(C.topLeftCorner<3, 3>().inverse() * off), 16.0) << z << ", " << factor << ", " << k;
      }
    }
  }
}

TEST(ShadowEdge, theTrackGoesThroughIt) {
  DockTracker tracker = makeTracker();
  for (unsigned k = 0; k < 12; ++k) {
    const scene::Print print = at(-0.1 + 0.01 * k, 0.9);
    cv::Mat image = drawn(print, k);
    if (k > 1) shade(image, {600.0 - 6.0 * k, 370.0}, 1.2, 0.5);
    const auto result = tracker.detect(image);
    ASSERT_EQ(result.markers.size(), 1u) << k;
    EXPECT_LT((result.markers[0].best().pose.translation() - print.T_optical_marker.translation()).norm(), 0.004) << k;
  }
}
