// Plain markers, frontal, turned and tilted, at whole and broken places, of every size: all have to be found.

#include <gtest/gtest.h>

#include "pose/marker_pose.h"
#include "scene.h"
#include "search/code/pattern_alignment.h"
#include "search/code/template_book.h"
#include "search/outline/dark_patches.h"
#include "search/outline/dark_pixels.h"
#include "search/outline/quad_search.h"

using namespace seater_perception;

namespace {

/// Frontal, its sides along the pixels, drawn on the pixel grid: `side` whole pixels at (x, y).
cv::Mat onThePixelGrid(int id, int side, int x, int y, double blur, int black = 40, int white = 215, int wall = 215) {
  cv::Mat image(720, 1280, CV_8U, cv::Scalar(wall)), print;
  cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50)->drawMarker(id, side, print);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column)
      image.at<uchar>(y + row, x + column) = print.at<uchar>(row, column) > 127 ? white : black;
  }
  if (blur > 0.0) cv::GaussianBlur(image, image, cv::Size(), blur);
  return image;
}

}  // namespace

// Codes are compared by what their cells show: as if each had been blurred point by point.
TEST(TemplateBook, comparesAsTheBlurredCodesThemselves) {
  const TemplateBook book(MarkerFamily::named("DICT_6X6_250"), {});
  for (const int level : {0, 5, 10}) {
    for (const int id : {0, 77, 249}) {
      PatternTemplate::Fit light;
      light.gain = 120.0;
      light.light = {40.0, 6.0, -9.0};
      ImageLevels::Samples samples;
      samples.grey = book.of(id, level).grey(light);
      samples.weights.setOnes(samples.grey.size());
      samples.seen = static_cast<int>(samples.grey.size());
      const auto best = book.compare(samples, level, 2);
      ASSERT_EQ(best.size(), 2U);
      EXPECT_EQ(best[0].id, id);
      EXPECT_EQ(best[0].turn, 0);
      EXPECT_NEAR(best[0].correlation, 1.0, 1e-5) << level;
      EXPECT_LT(best[1].correlation, 0.95) << level;
    }
  }
}

// A code in each orientation, of a family whose codes fill no whole number of blocks, and of some ids of it.
TEST(TemplateBook, namesTheOrientation) {
  const MarkerFamily family = MarkerFamily::named("DICT_6X6_250");
  for (const std::set<int>& ids : {std::set<int>{}, std::set<int>{3, 77, 200}}) {
    const TemplateBook book(family, ids);
    PatternTemplate::Fit light;
    light.gain = 120.0;
    light.light = {40.0, 6.0, -9.0};
    ImageLevels::Samples samples;
    const Eigen::VectorXf upright = book.of(77, 5).grey(light);
    samples.weights.setOnes(upright.size());
    samples.seen = static_cast<int>(upright.size());
    for (int turn = 0; turn < 4; ++turn) {
      // Turned the other way round: what `turned` takes back.
      samples.grey = turned(upright, book.grid().along(), (4 - turn) % 4);
      const auto best = book.compare(samples, 5, 1);
      ASSERT_EQ(best.size(), 1U);
      EXPECT_EQ(best[0].id, 77);
      EXPECT_EQ(best[0].turn, turn);
      EXPECT_LT((turned(samples.grey, book.grid().along(), turn) - upright).norm(), 1e-6);
      EXPECT_NEAR(best[0].correlation, 1.0, 1e-5);
    }
  }
}

/// A marker of DICT_6X6_250 without any blur, its first corner three cells from the image's.
cv::Mat withoutBlur(const MarkerFamily& family, int id, int cell) {
  const int cells = family.cells(), length = cell * (cells + 6);
  cv::Mat image(length, length, CV_8U, cv::Scalar(170));
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const bool white = family.pattern(id).at(column, cells - 1 - row) > 0.5;
      const cv::Rect there(cell * (3 + column), cell * (3 + row), cell, cell);
      cv::rectangle(image, there, cv::Scalar(white ? 170 : 80), cv::FILLED);
    }
  }
  return image;
}

// Edges are sharper in the image than in any template: whole steps of the fit are nearly twice too long. Measured: a
// corner is 0.026 cells off in the end, 0.9996 is explained; with whole steps 0.29 and 0.963.
TEST(PatternAligner, doesNotGoToAndFro) {
  const MarkerFamily family = MarkerFamily::named("DICT_6X6_250");
  const TemplateBook book(family, {});
  const PatternAligner aligner(book);
  constexpr int kCell = 5;
  const cv::Mat image = withoutBlur(family, 77, kCell);
  const double low = 3.0 * kCell - 0.5, high = low + kCell * family.cells();
  const Quad truth{Eigen::Vector2d(low, low), {high, low}, {high, high}, {low, high}};
  Alignment a;
  a.id = 77;
  a.quad = truth;
  a.quad[0] += Eigen::Vector2d(0.1, -0.1) * kCell;
  a.quad[2] += Eigen::Vector2d(0.2, 0.1) * kCell;
  Alignment other = a;
  const ImageLevels levels(image);
  ASSERT_TRUE(aligner.align(levels, a));
  EXPECT_GT(a.fit.explained, 0.99);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((a.quad[i] - truth[i]).norm(), 0.1 * kCell);
  // Another code explains less, and is given up where so much is asked for.
  other.id = 76;
  EXPECT_FALSE(aligner.align(levels, other, 0.7));
}

// A round blur is made of rows and columns; any other by the series for both together.
TEST(PatternTemplate, ofARoundBlurIsThatOfAnyBlur) {
  const MarkerFamily family = MarkerFamily::named("DICT_6X6_250");
  const PatternGrid grid(family.cells(), family.border());
  for (const double sd : {0.12, 0.36, 0.75}) {
    const PatternTemplate round(grid, family.pattern(77), RoundBlur(grid, sd));
    const PatternTemplate any(grid, family.pattern(77), Eigen::Matrix2d(sd * sd * Eigen::Matrix2d::Identity()));
    PatternTemplate::Fit light;
    light.gain = 120.0;
    light.quiet = -30.0;
    light.light = {40.0, 6.0, -9.0};
    const Eigen::VectorXf grey = round.grey(light);
    EXPECT_LT((grey - any.grey(light)).cwiseAbs().maxCoeff(), 0.02) << sd;
    EXPECT_NEAR(round.ownFraction(), any.ownFraction(), 1e-12);
    // Grey levels of an image: what one does not explain of them, the other reads as the same motion.
    const Eigen::VectorXf image =
        grey + 5.0f * Eigen::VectorXf::LinSpaced(grey.size(), -1.0f, 1.0f).array().cos().matrix();
    const auto a = round.fit(image, nullptr, true), b = any.fit(image, nullptr, true);
    ASSERT_TRUE(a && b);
    EXPECT_LT((a->motion - b->motion).norm(), 1e-3) << sd;
  }
}

// The reference is OpenCV's, which follows all outlines and sorts all points.
TEST(DarkPatches, haveTheOutlinesAndHullsOfAllThatIsDark) {
  cv::RNG random(3);
  cv::Mat noise(240, 325, CV_8U), dark;  // no whole number of words
  random.fill(noise, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(noise, noise, cv::Size(), 2.0);
  dark = noise < 126;
  std::vector<std::vector<cv::Point>> outlines;
  std::vector<cv::Vec4i> tree;
  cv::findContours(dark, outlines, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  const auto before = [](const cv::Point& a, const cv::Point& b) { return std::tie(a.y, a.x) < std::tie(b.y, b.x); };
  const auto sorted = [before](std::vector<cv::Point> points) {
    std::sort(points.begin(), points.end(), before);
    return points;
  };
  std::vector<std::vector<cv::Point>> expected;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const cv::Rect box = cv::boundingRect(outlines[i]);
    const bool inside = box.x > 0 && box.y > 0 && box.br().x < dark.cols && box.br().y < dark.rows;
    const bool around_hole = tree[i][3] >= 0;
    if (inside && !around_hole) expected.push_back(outlines[i]);
  }
  const auto earlier = [before](const auto& a, const auto& b) { return before(a[0], b[0]); };
  std::sort(expected.begin(), expected.end(), earlier);
  const std::vector<DarkPatch> patches = darkPatches(dark, 0.0);
  ASSERT_GT(patches.size(), 50U);
  ASSERT_EQ(patches.size(), expected.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    std::vector<cv::Point> hull;
    cv::convexHull(expected[i], hull);
    EXPECT_EQ(sorted(patches[i].hull), sorted(hull));
    EXPECT_EQ(outlineOf(dark, patches[i].first), expected[i]);
  }
}

// The rows overlap in whole words, the last one ends within one.
TEST(DarkPatches, areLeftOutWhereTheyAreSmall) {
  cv::Mat dark = cv::Mat::zeros(40, 200, CV_8U);
  cv::rectangle(dark, {3, 3, 130, 20}, cv::Scalar(255), cv::FILLED);
  cv::rectangle(dark, {150, 5, 6, 6}, cv::Scalar(255), cv::FILLED);
  ASSERT_EQ(darkPatches(dark, 25.0).size(), 2U);
  const auto large = darkPatches(dark, 26.0);
  ASSERT_EQ(large.size(), 1U);
  EXPECT_EQ(large[0].first, cv::Point(3, 3));
  EXPECT_EQ(large[0].hull.size(), 4U);
}

// A dark square within a light one within a dark one: only the dark ones have a print's outline, and a known one none.
TEST(QuadSearch, seesTheOutlinesOfWhatIsDark) {
  cv::Mat image(200, 200, CV_8U, cv::Scalar(200));
  cv::rectangle(image, {20, 20, 160, 160}, cv::Scalar(40), cv::FILLED);
  cv::rectangle(image, {50, 50, 100, 100}, cv::Scalar(200), cv::FILLED);
  cv::rectangle(image, {80, 80, 40, 40}, cv::Scalar(40), cv::FILLED);
  QuadSearch search;
  search.window = 101;
  const std::vector<Quad> quads = findQuads(image, search);
  ASSERT_EQ(quads.size(), 2U);
  const Quad& inner = meanSide(quads[0]) < meanSide(quads[1]) ? quads[0] : quads[1];
  EXPECT_NEAR(meanSide(inner), 40.0, 2.5);  // the step that the threshold cuts is two pixels wide
  const std::vector<Quad> rest = findQuads(image, search, {inner});
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_NEAR(meanSide(rest[0]), 160.0, 2.5);
}

cv::Mat adaptiveThreshold(const cv::Mat& image, int window, double constant) {
  cv::Mat dark;
  cv::adaptiveThreshold(image, dark, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, window, constant);
  return dark;
}

TEST(DarkPixels, areThoseOfTheAdaptiveThreshold) {
  cv::Mat image(150, 201, CV_8U), smooth;
  cv::RNG(3).fill(image, cv::RNG::NORMAL, 120.0, 25.0);
  cv::blur(image, smooth, cv::Size(3, 3), cv::Point(-1, -1), cv::BORDER_REPLICATE);
  for (const int window : {5, 25, 255}) {
    for (const double constant : {4.0, 7.5}) {
      DarkPixels what{window, constant, false, false};
      EXPECT_EQ(cv::countNonZero(darkPixels(image, what) != adaptiveThreshold(image, window, constant)), 0) << window;
      what.smooth = true;
      EXPECT_EQ(cv::countNonZero(darkPixels(image, what) != adaptiveThreshold(smooth, window, constant)), 0) << window;
    }
  }
}

// A blurred step (sd 1 px) of 30: 1.5 px inside, pixels are 4.4 darker than the mean over 5 px.
TEST(DarkPixels, areMoreWhereGreyLevelsDifferLittle) {
  cv::Mat image(150, 200, CV_8U, cv::Scalar(100));
  cv::rectangle(image, {60, 50, 40, 40}, cv::Scalar(70), cv::FILLED);
  cv::GaussianBlur(image, image, {}, 1.0);
  DarkPixels what{5, 7.0, false, false};
  EXPECT_EQ(darkPixels(image, what).at<uchar>(70, 61), 0);
  what.faint = true;
  const cv::Mat dark = darkPixels(image, what);
  EXPECT_EQ(dark.at<uchar>(70, 61), 255);
  EXPECT_EQ(dark.at<uchar>(70, 80), 0);
  EXPECT_EQ(dark.at<uchar>(70, 40), 0);
}

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

TEST(PlainMarkers, onThePixelGridAreFoundWhereTheyAre) {
  DockDetector detector(CameraModel::raw(scene::calibration()), layoutOfEqualMarkers("DICT_4X4_50", 0.1),
                        PerceptionParameters(), CameraMount());
  for (const int side : {18, 24, 30, 36, 48, 60, 96, 120, 126, 180, 240, 300, 420, 600}) {
    for (const double blur : {0.8, 1.3}) {
      const int id = (3 * side) % 50, x = 500 - side / 3, y = std::min(300, 700 - side);
      const auto result = detector.detect(onThePixelGrid(id, side, x, y, blur));
      EXPECT_EQ(result.refused, 0) << side << " px, blur " << blur;
      EXPECT_EQ(result.markers.size(), 1u) << side << " px, blur " << blur;
      if (result.markers.size() != 1u) continue;
      EXPECT_EQ(result.markers[0].id, id);
      const double left = x - 0.5, top = y - 0.5, right = left + side, bottom = top + side;
      const std::array<Eigen::Vector2d, 4> truth{Eigen::Vector2d(left, top), Eigen::Vector2d(right, top),
                                                 Eigen::Vector2d(right, bottom), Eigen::Vector2d(left, bottom)};
      for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_LT((result.markers[0].corners[i] - truth[i]).norm(), 0.1) << side << " px, blur " << blur;
      }
    }
  }
}

TEST(PlainMarkers, turnedAndTiltedAreFound) {
  const Calibration c = scene::calibration();
  DockDetector detector(CameraModel::raw(c), layoutOfEqualMarkers("DICT_4X4_50", 0.1), PerceptionParameters(),
                        CameraMount());
  int number = 0;
  for (const double side : {12.0, 14.3, 17.0, 22.5, 31.0, 45.0, 70.0, 126.0, 250.0, 400.0, 600.0}) {
    for (const double tilt : {0.0, 0.3, 0.7}) {
      for (const double roll : {0.0, 0.4, M_PI}) {
        for (const double noise : {0.0, 3.0}) {
          if (tilt > 0.5 && (side < 20.0 || side > 400.0)) continue;  // too small, too large for the image
          if (side > 450.0 && roll == 0.4) continue;                  // does not fit into the image
          ++number;
          if ((number / 2 + (noise > 0.0 ? 1 : 0)) % 2 == 0 && !scene::extensive()) continue;  // with noise or without
          const double z = 640.0 * 0.1 / side, off = side > 300.0 ? 0.01 : 0.2;
          const scene::Print print{(7 * number) % 50, 0.1,
                                   scene::upright({off * z, -0.3 * off * z, z}, tilt, 0.2 * tilt, roll)};
          scene::Look look;
          look.noise = noise;
          const auto result =
              detector.detect(scene::draw(c, "DICT_4X4_50", {print}, look, static_cast<unsigned>(number)));
          const auto what = [&] {
            return std::to_string(side) + " px, tilt " + std::to_string(tilt) + ", roll " + std::to_string(roll) +
                   ", noise " + std::to_string(noise);
          };
          EXPECT_EQ(result.refused, 0) << what();
          EXPECT_EQ(result.markers.size(), 1u) << what();
          if (result.markers.size() != 1u) continue;
          EXPECT_EQ(result.markers[0].id, print.id) << what();
          const auto truth = scene::trueCorners(c, print);
          for (std::size_t i = 0; i < 4; ++i)
            EXPECT_LT((result.markers[0].corners[i] - truth[i]).norm(), 0.25) << what();
        }
      }
    }
  }
}

// Drawn images are what people try first: without blur, black and white at the sensor's limits, and pasted on a grey
// that is darker than the print's white, as a print is whose margin was cut off.
TEST(PlainMarkers, aQuietZoneNeedNotBeAsWhiteAsThePrint) {
  const MarkerDetector detector(MarkerFamily::named("DICT_4X4_50"), DetectorParameters());
  const int levels[][3] = {{0, 255, 200},  {0, 200, 200},  {40, 240, 230}, {0, 255, 255}, {40, 255, 200},
                           {40, 240, 160}, {40, 240, 200}, {0, 250, 200},  {40, 200, 215}};
  for (const auto& [black, white, wall] : levels) {
    for (const double blur : {0.0, 0.8}) {
      for (const int side : {24, 60, 200}) {
        const auto found = detector.detect(onThePixelGrid(7, side, 500, 300, blur, black, white, wall)).markers;
        ASSERT_EQ(found.size(), 1u) << black << " " << white << " " << wall << ", blur " << blur << ", " << side
                                    << " px";
        EXPECT_EQ(found[0].id, 7);
        EXPECT_LT((found[0].corners[0] - Eigen::Vector2d(499.5, 299.5)).norm(), 0.03 * side);
      }
    }
  }
}
