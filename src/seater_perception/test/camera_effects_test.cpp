// What cameras do to an image: resolution, lens distortion, exposure that changes, motion during the exposure.
// Images are drawn by photometric_scene.h: lens and motion exactly, on a fine grid.

#include <gtest/gtest.h>

#include "photometric_scene.h"
#include "seater_perception/dock_tracker.h"

using namespace seater_perception;
using photo_scene::Vector2d;
using photo_scene::Vector3d;
using photo_scene::View;

namespace {

struct Resolution {
  int width, height;
  const char* model;  // the lens that is always tried with it
};
constexpr Resolution kResolutions[] = {{320, 240, "equidistant"},
                                       {640, 480, "plumb_bob"},
                                       {1280, 720, "rational_polynomial"},
                                       {1920, 1080, "equidistant"}};

/// A lens of 90 deg across; the rational one is a wide-angle lens' typical set, the fisheye sees 115 deg.
Calibration cameraOf(const Resolution& r, const std::string& model) {
  Calibration c = scene::calibration(0.5 * r.width, r.width, r.height);
  c.distortion_model = model;
  if (model == "plumb_bob") {
    c.D = {-0.28, 0.09, 0.0006, -0.0004, -0.012};
  } else if (model == "equidistant") {
    c.D = {-0.02, 0.008, -0.006, 0.001};
  } else {
    c.D = {0.35, -0.09, 0.0005, -0.0003, -0.01, 0.66, -0.05, -0.03};
  }
  return c;
}

/// One marker of the dock, `side` pixels wide, in a part of the image where the lens is felt.
View viewOf(const Calibration& c, double side, const Vector2d& ray, double yaw) {
  View view;
  view.camera = c;
  const double z = c.K[0] * 0.1 / side;
  view.pose = scene::upright(Vector3d(ray.x() * z, ray.y() * z, z), yaw);
  view.prints = {{0, 0.1, view.pose}};
  view.samples = 6;
  return view;
}

double positionError(const DetectionResult& result, const Eigen::Isometry3d& truth) {
  if (result.markers.size() != 1) return std::numeric_limits<double>::infinity();
  return (result.markers[0].best().pose.translation() - truth.translation()).norm();
}

DockTracker trackerOf(const Calibration& c, const PerceptionParameters& parameters = PerceptionParameters()) {
  return DockTracker(CameraModel::raw(c), scene::defaultDock(), parameters, CameraMount());
}

/// Of a marker of `side` px, `pixels` of error of its side, as a distance [m].
double asDistance(const View& view, double pixels) {
  const double z = view.pose.translation().z();
  return pixels * z * z / (view.camera.K[0] * 0.1);
}

/// Worst error of the side [px] over paths along and across the rows and obliquely; infinite when one is not found. The
/// image before stands still; then the chair turns, so the track has to keep a marker that the search may lose.
double worstWithMotion(const char* blur, double length, double side) {
  const Calibration c = scene::calibration();
  PerceptionParameters parameters;
  parameters.photometric.psf_model = blur;
  double worst = 0.0;
  for (const double angle : {0.0, 1.5708, 0.6}) {
    DockTracker tracker = trackerOf(c, parameters);
    View view = viewOf(c, side, Vector2d(0.1, -0.05), 0.35);
    tracker.detect(photo_scene::withNoise(photo_scene::clean(view), 2.0, 1));
    view.motion = length * Vector2d(std::cos(angle), std::sin(angle));
    const DetectionResult result = tracker.detect(photo_scene::withNoise(photo_scene::clean(view), 2.0, 2));
    worst = std::max(worst, positionError(result, view.pose) / asDistance(view, 1.0));
  }
  std::printf("  blur %s, %.0f px side, path %.0f px: worst error of the side %.3f px\n", blur, side, length, worst);
  return worst;
}

}  // namespace

// The error along the line of sight is that of the side: 0.1 px of it are allowed (the Cramer-Rao bound is 0.01 to
// 0.03 px; a wrong lens model costs more than 1 px).
TEST(Camera, AnyResolutionAndLensModel) {
  for (const Resolution& r : kResolutions) {
    for (const std::string model : {"plumb_bob", "rational_polynomial", "equidistant"}) {
      if (model != r.model && !scene::extensive()) continue;
      const Calibration c = cameraOf(r, model);
      DockTracker tracker = trackerOf(c);
      double worst = 0.0;
      // From image to image it moves on by a tenth of its side, as before a driving chair.
      for (int k = 0; k < 4; ++k) {
        const double side = 0.06 * r.width + 20.0;
        const Vector2d ray(-0.52 + 0.1 * side / c.K[0] * k, 0.27);
        const View view = viewOf(c, side, ray, 0.4);
        const cv::Mat image = photo_scene::withNoise(photo_scene::clean(view), 3.0, static_cast<unsigned>(k));
        const DetectionResult result = tracker.detect(image);
        const double error = positionError(result, view.pose);
        EXPECT_LT(error, asDistance(view, 0.1)) << r.width << " x " << r.height << ", " << model << ", image " << k;
        EXPECT_EQ(result.full_search, k == 0 || !PerceptionParameters().tracking.enabled);
        worst = std::max(worst, error / asDistance(view, 1.0));
        if (k > 0) continue;
        Calibration straight = c;
        straight.distortion_model = "plumb_bob";
        straight.D.clear();
        EXPECT_GT(positionError(trackerOf(straight).detect(image), view.pose), asDistance(view, 0.3))
            << "the lens is not felt here: the test is too easy";
      }
      std::printf("  %4d x %4d, %-19s worst error of the side %.3f px\n", r.width, r.height, model.c_str(), worst);
    }
  }
}

// Gain from a third to more than the sensor can take of white paper, jumping from image to image, and within each
// image falling by a third from top to bottom (rolling shutter under a lamp that changes).
TEST(Camera, ExposureMayChangeFromImageToImageAndWithinOne) {
  const Calibration c = scene::calibration();
  DockTracker tracker = trackerOf(c);
  const double gains[] = {1.0, 0.35, 1.0, 1.25, 0.5, 0.8, 0.3, 1.3};
  int k = 0;
  for (const double gain : gains) {
    const View view = viewOf(c, 60.0, Vector2d(0.1 + 0.01 * k, -0.05), 0.35);
    cv::Mat image = photo_scene::clean(view);
    for (int y = 0; y < image.rows; ++y) image.row(y) *= gain * (1.15 - 0.3 * y / image.rows);
    const DetectionResult result = tracker.detect(photo_scene::withNoise(image, 2.0, static_cast<unsigned>(100 + k)));
    const double error = positionError(result, view.pose);
    std::printf("  gain %.2f: %.2f mm\n", gain, 1e3 * error);
    EXPECT_LT(error, asDistance(view, 0.1)) << "gain " << gain;
    ++k;
  }
}

// A lens blurs light, the tone curve comes after it. In grey levels white has then grown into black: 0.3 to 0.5 px at
// corners, which a fit that knows nothing of it shows (outline of 60 px: 1 % of the distance).
TEST(Camera, ToneCurveAfterTheLens) {
  const Calibration c = scene::calibration();
  for (const double exponent : {1.0, 2.2}) {
    for (const double side : {40.0, 90.0}) {
      View view = viewOf(c, side, Vector2d(0.1, -0.05), 0.5);
      const auto light = [exponent](double grey) { return 255.0 * std::pow(grey / 255.0, exponent); };
      view.blur = 0.9, view.black = light(60.0), view.white = light(225.0);
      cv::Mat image = photo_scene::clean(view) / 255.0;
      cv::pow(image, 1.0 / exponent, image);
      DockTracker tracker = trackerOf(c);
      for (unsigned seed = 1; seed <= 2; ++seed) {  // searched, then tracked
        const DetectionResult result = tracker.detect(photo_scene::withNoise(255.0 * image, 1.5, seed));
        const double error = positionError(result, view.pose) / asDistance(view, 1.0);
        std::printf("  exponent %.1f, side %.0f px: error of the side %.3f px\n", exponent, side, error);
        EXPECT_LT(error, 0.1);
        ASSERT_EQ(result.markers.size(), 1U);
        EXPECT_EQ(result.markers[0].stage, PoseStage::photometric);
        EXPECT_EQ(result.full_search, seed == 1);
      }
    }
  }
}

// One round blur describes a path of some pixels, one blur for each direction a longer one.
TEST(Camera, MotionBlurUpToEightPixels) {
  for (const double side : {60.0, 100.0}) {
    for (const double length : {4.0, 8.0}) EXPECT_LT(worstWithMotion("directed", length, side), 0.1);
    EXPECT_LT(worstWithMotion("estimated", 4.0, side), 0.1);
    if (!scene::extensive()) continue;
    for (const double length : {2.0, 6.0}) EXPECT_LT(worstWithMotion("directed", length, side), 0.1);
    EXPECT_LT(worstWithMotion("estimated", 2.0, side), 0.1);
  }
}
