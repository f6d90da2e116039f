// The track in the cases that go wrong in the field: covered and exchanged markers, jumps, changes of size, motion
// blur.

#include <gtest/gtest.h>

#include <functional>

#include "scene.h"
#include "seater_perception/dock_tracker.h"

using namespace seater_perception;

namespace {

const Calibration kCamera = scene::calibration();

scene::Print at(int id, double x, double z, double yaw = 0.2) {
  return {id, 0.1, scene::upright({x, 0.02, z}, yaw)};
}

cv::Mat drawn(const std::vector<scene::Print>& prints, unsigned seed, const scene::Look& look = scene::Look()) {
  return scene::draw(kCamera, "DICT_4X4_50", prints, look, seed);
}

/// Mean of the same scene along the path of an exposure: `path` [px] to the side, in steps of half a pixel.
cv::Mat drawnMoving(const scene::Print& print, double path, unsigned seed) {
  scene::Look sharp;
  sharp.noise = 0.0;
  const int steps = static_cast<int>(2.0 * path) + 1;
  cv::Mat sum(kCamera.height, kCamera.width, CV_32F, cv::Scalar(0));
  for (int k = 0; k < steps; ++k) {
    scene::Print moved = print;
    moved.T_optical_marker.translation().x() +=
        (k / (steps - 1.0) - 0.5) * path * print.T_optical_marker.translation().z() / 640.0;
    cv::Mat part;
    drawn({moved}, 0, sharp).convertTo(part, CV_32F);
    sum += part / steps;
  }
  cv::Mat noise(sum.size(), CV_32F), grey;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, 3.0);
  cv::Mat(sum + noise).convertTo(grey, CV_8U);
  return grey;
}

void cover(cv::Mat& image, const scene::Print& print, double from, double to) {
  const auto corners = scene::trueCorners(kCamera, print);
  const double width = corners[1].x() - corners[0].x();
  const cv::Point a(cvRound(corners[0].x() + from * width), cvRound(corners[0].y() - 0.3 * width));
  const cv::Point b(cvRound(corners[0].x() + to * width), cvRound(corners[2].y() + 0.3 * width));
  cv::rectangle(image, a, b, cv::Scalar(120), cv::FILLED);
}

DockTracker makeTracker(int full_search_every = 1000) {
  PerceptionParameters parameters;
  parameters.tracking.full_search_every = full_search_every;
  return DockTracker(CameraModel::raw(kCamera), scene::defaultDock(), parameters, CameraMount());
}

std::vector<int> idsIn(const DetectionResult& result) {
  std::vector<int> ids;
  for (const auto& m : result.markers) ids.push_back(m.id);
  return ids;
}

}  // namespace

TEST(TrackerCases, aCoveredMarkerIsNotReportedAndComesBack) {
  DockTracker tracker = makeTracker();
  const scene::Print print = at(0, 0.0, 1.2);
  const cv::Mat seen = drawn({print}, 1);
  ASSERT_EQ(idsIn(tracker.detect(seen)), std::vector<int>{0});
  for (unsigned k = 2; k < 5; ++k) {
    cv::Mat covered = drawn({print}, k);
    cover(covered, print, -0.3, 1.3);
    EXPECT_TRUE(tracker.detect(covered).markers.empty());
    cv::Mat half = drawn({print}, 10 + k);
    cover(half, print, 0.4, 1.3);
    EXPECT_TRUE(tracker.detect(half).markers.empty()) << "a half says too little of the code";
  }
  EXPECT_EQ(idsIn(tracker.detect(seen)), std::vector<int>{0});
}

// One of each pair of the dock's and of two strange ids, covered first or exchanged at once.
TEST(TrackerCases, anotherMarkerInItsPlaceIsNeverTakenForIt) {
  for (const double z : {0.6, 1.2, 2.5, 4.0}) {
    for (const int other : {1, 33, 2, 9}) {  // of the dock, of the dictionary
      if ((other == 2 || other == 9) && !scene::extensive()) continue;
      for (const bool covered_first : {false, true}) {
        DockTracker tracker = makeTracker();
        const scene::Print print = at(0, 0.0, z);
        scene::Print strange = print;
        strange.id = other;
        ASSERT_EQ(idsIn(tracker.detect(drawn({print}, 1))), std::vector<int>{0}) << z;
        if (covered_first) {
          cv::Mat covered = drawn({print}, 2);
          cover(covered, print, -0.3, 1.3);
          EXPECT_TRUE(tracker.detect(covered).markers.empty());
        }
        for (unsigned k = 3; k < 6; ++k) {
          const auto ids = idsIn(tracker.detect(drawn({strange}, k)));
          EXPECT_EQ(ids, other < 3 ? std::vector<int>{other} : std::vector<int>{}) << z << " m, " << other;
        }
      }
    }
  }
}

TEST(TrackerCases, followsWithinTheMarginAndSearchesAfterAJump) {
  for (const double jump : {0.005, 0.02, 0.06, 0.4, -0.5}) {  // [m] at 1.2 m: 3, 11, 32, 213, 267 px
    DockTracker tracker = makeTracker();
    tracker.detect(drawn({at(0, 0.0, 1.2)}, 1));
    tracker.detect(drawn({at(0, 0.0, 1.2)}, 2));
    const scene::Print after = at(0, jump, 1.2);
    const auto result = tracker.detect(drawn({after}, 3));
    ASSERT_EQ(idsIn(result), std::vector<int>{0}) << jump;
    EXPECT_EQ(result.full_search, std::abs(jump) > 0.1) << jump;
    EXPECT_LT((result.markers[0].best().pose.translation() - after.T_optical_marker.translation()).norm(), 0.003);
  }
}

TEST(TrackerCases, followsAChangeOfSizeAndATurn) {
  DockTracker tracker = makeTracker();
  double z = 2.5, yaw = -0.3;
  for (unsigned k = 0; k < 14; ++k) {
    const scene::Print print{0, 0.1, scene::upright({0.05 * z, 0.0, z}, yaw, 0.0, 0.03 * k)};
    const auto result = tracker.detect(drawn({print}, k));
    ASSERT_EQ(idsIn(result), std::vector<int>{0}) << z;
    EXPECT_EQ(result.full_search, k == 0) << z;
    z *= k == 6 ? 0.75 : 0.88;  // once a third larger from one image to the next
    yaw += 0.05;
  }
}

TEST(TrackerCases, keepsAMarkerThroughMotionBlur) {
  for (const double side : {20.0, 30.0, 64.0, 120.0}) {
    for (const double path : {4.0, 8.0}) {
      if (path < 8.0 && !scene::extensive()) continue;
      DockTracker tracker = makeTracker();
      double x = -0.1;
      const double z = 64.0 / side;
      ASSERT_EQ(idsIn(tracker.detect(drawn({at(0, x, z)}, 1))), std::vector<int>{0});
      for (unsigned k = 2; k < 6; ++k) {
        x += path * z / 640.0;
        const auto result = tracker.detect(drawnMoving(at(0, x, z), path, k));
        EXPECT_FALSE(result.full_search) << side << " px, path " << path;
        EXPECT_EQ(idsIn(result), std::vector<int>{0}) << side << " px, path " << path;
      }
    }
  }
}

// Down to contrasts that the full search does not take for proved.
TEST(TrackerCases, keepsADimMarkerThatTheSearchDoesNotFind) {
  const scene::Print print = at(0, 0.0, 3.6, 0.0);
  DockDetector detector(CameraModel::raw(kCamera), scene::defaultDock(), PerceptionParameters(), CameraMount());
  for (const double contrast : {40.0, 22.0}) {
    scene::Look dim;
    dim.blur = 1.3;
    dim.noise = 3.0;
    dim.black = 120.0 - 0.5 * contrast, dim.white = 120.0 + 0.5 * contrast, dim.wall = 120.0 + 0.25 * contrast;
    DockTracker tracker = makeTracker();
    ASSERT_EQ(idsIn(tracker.detect(drawn({print}, 1))), std::vector<int>{0});
    int kept = 0, searched = 0;
    for (unsigned k = 2; k < 22; ++k) {
      const cv::Mat image = drawn({print}, k, dim);
      const auto result = tracker.detect(image);
      kept += !result.full_search && idsIn(result) == std::vector<int>{0};
      searched += detector.detect(image).markers.size() == 1;
      tracker.detect(drawn({print}, 100 + k));  // so that each image is judged for itself
    }
    std::printf("  contrast %.0f, 18 px: kept in %d of 20 images, found by the search in %d\n", contrast, kept,
                searched);
    EXPECT_GE(kept, 18) << contrast;
    if (contrast < 30.0) {
      EXPECT_LT(searched, kept);
    }
  }
}

// A decoy that was seen first must not stay because the track would follow it.
TEST(TrackerCases, anIdAtTwoPlacesIsForgotten) {
  DockTracker tracker = makeTracker(4);
  const scene::Print first = at(0, -0.2, 1.2), second = at(0, 0.3, 1.2);
  for (unsigned k = 0; k < 2; ++k) ASSERT_EQ(idsIn(tracker.detect(drawn({first}, k))), std::vector<int>{0});
  bool searched = false;
  for (unsigned k = 2; k < 14; ++k) {
    const auto result = tracker.detect(drawn({first, second}, k));
    searched |= result.full_search;
    EXPECT_TRUE(!searched || result.markers.empty()) << k;
  }
  EXPECT_TRUE(searched);
  for (unsigned k = 14; k < 19; ++k) searched = !tracker.detect(drawn({second}, k)).markers.empty();
  EXPECT_TRUE(searched) << "alone again, it is believed again";
}
