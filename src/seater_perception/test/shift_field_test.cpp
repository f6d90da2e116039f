// Smooth shifts of the image: how large they are by what fits have left over, and what they do to a pose.

#include "pose/shift_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "numerics/solve.h"
#include "numerics/symmetric.h"
#include "scene.h"

using namespace seater_perception;

namespace {

constexpr double kUsual = 0.1, kSmoothness = 14.0;  // [px]

/// What a marker leaves over: directions along which shifts of variance `variance` [px^2] add that times 1 to `most` to
/// noise of 1, and whose noise is `alike` times as large as independent errors make it.
ShiftEvidence drawn(double variance, double most, double alike, std::mt19937& random) {
  std::normal_distribution<double> normal;
  ShiftEvidence evidence;
  for (int mode = 0; mode < 10; ++mode) {
    const double m = most * std::pow(0.5, mode), value = normal(random),
                 square = value * value * (alike + variance * m);
    ShiftGrid::forEach([&](int a, int shift, int, std::size_t i) {
      const double v = ShiftGrid::alike(a) + ShiftGrid::shift(shift) * ShiftGrid::shift(shift) * m;
      evidence.log_likelihood[i] -= 0.5 * (std::log(v) + square / v);
    });
  }
  return evidence;
}

/// Mean over many images of what three markers tell, by root mean square.
ShiftEstimate meanEstimate(double variance, double most, double alike, double usual, bool as_modelled) {
  std::mt19937 random(3);
  constexpr int kImages = 100;
  ShiftEstimate mean{0.0, 0.0, 0.0};
  for (int i = 0; i < kImages; ++i) {
    ShiftField field;
    for (int marker = 0; marker < 3; ++marker) field.add(drawn(variance, most, alike, random), 1.0);
    const ShiftEstimate estimate = field.estimate(usual, as_modelled);
    mean.alike += estimate.alike / kImages;
    mean.sigma += estimate.sigma * estimate.sigma / kImages;
  }
  mean.sigma = std::sqrt(mean.sigma);
  return mean;
}

}  // namespace

TEST(ShiftField, ComesOutOfWhatIsLeftOver) {
  for (const double sigma : {0.05, 0.1, 0.3}) {
    const ShiftEstimate seen = meanEstimate(sigma * sigma, 1e5, 1.0, kUsual, true);
    EXPECT_GT(seen.sigma, sigma) << sigma;  // the mean of its square, as it is not known exactly
    EXPECT_LT(seen.sigma, 1.5 * sigma) << sigma;
    EXPECT_LT(seen.alike, 2.0) << sigma;
  }
}

TEST(ShiftField, NoneIsSeenWhereMarkersWouldShowIt) {
  EXPECT_LT(meanEstimate(0.0, 1e8, 1.0, kUsual, true).sigma, 0.01);
  // Where the camera is not as modelled, none at all is not believed.
  EXPECT_GT(meanEstimate(0.0, 1e5, 1.0, kUsual, false).sigma, meanEstimate(0.0, 1e5, 1.0, kUsual, true).sigma);
}

TEST(ShiftField, ErrorsThatAreAlikeAreNoShifts) {
  const ShiftEstimate seen = meanEstimate(0.0, 1e4, 6.0, kUsual, false);
  EXPECT_GT(seen.alike, 3.0);
  EXPECT_LT(seen.alike, 9.0);
  EXPECT_LT(seen.sigma, 0.1);  // as shifts alone, they would be 0.2 px
}

TEST(ShiftField, IsThePriorWhereNothingTells) {
  const double unknown = ShiftField().estimate(kUsual, false).sigma;
  EXPECT_GT(unknown, kUsual);
  EXPECT_LT(unknown, 5.0 * kUsual);
  EXPECT_LT(ShiftField().estimate(0.5 * kUsual, false).sigma, unknown);
  EXPECT_LT(ShiftField().estimate(0.0, false).sigma, unknown);
  EXPECT_NEAR(meanEstimate(0.0, 1.0, 1.0, kUsual, false).sigma, unknown, 0.2 * unknown);  // a direction's noise is 1 px
}

TEST(ShiftField, OthersCountByTheirWeight) {
  std::mt19937 random(4);
  ShiftField own, heavy, light;
  const ShiftEvidence quiet = drawn(0.0, 1e5, 1.0, random), moved = drawn(0.09, 1e5, 1.0, random);
  for (ShiftField* field : {&own, &heavy, &light}) field->add(quiet, 1.0);
  heavy.add(moved, 1.0);
  light.add(moved, 0.01);
  const auto sigma = [](const ShiftField& field) { return field.estimate(kUsual, false).sigma; };
  EXPECT_LT(sigma(own), sigma(light));
  EXPECT_LT(sigma(light), sigma(heavy));
}

TEST(ShiftField, PoseFollowsAsDrawnFieldsMakeIt) {
  const CameraModel camera = CameraModel::raw(scene::calibration());
  const Eigen::Isometry3d pose = scene::upright({0.2, 0.1, 1.2}, 0.5, 0.2);
  ShiftedPlaces places;
  places.add(0.1, Eigen::Isometry3d::Identity(), 0.2);
  const std::size_t count = places.object.size();
  std::vector<Eigen::Vector2d> seen;
  Eigen::MatrixXd J(2 * count, 6);
  SmallMatrix alike(count, count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d arm = pose.linear() * places.object[i];
    seen.push_back(*camera.project(pose * places.object[i]));
    J.middleRows<2>(2 * i) = pixelByPose(camera, arm, arm + pose.translation());
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < count; ++k)
      alike(i, k) = std::exp(-(seen[i] - seen[k]).squaredNorm() / (4.0 * kSmoothness * kSmoothness));
  }
  const auto root = choleskyRoot(alike);
  ASSERT_TRUE(root);
  const Eigen::MatrixXd solve = inverted(J.transpose().lazyProduct(J)).lazyProduct(J.transpose());
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.2);
  constexpr int kDraws = 4000;
  Matrix6d sum = Matrix6d::Zero();
  for (int n = 0; n < kDraws; ++n) {
    const Eigen::MatrixXd drawn = Eigen::MatrixXd::NullaryExpr(count, 2, [&] { return normal(random); });
    const Eigen::MatrixXd rows = root->lazyProduct(drawn).transpose();
    const Vector6d change = solve * Eigen::Map<const Eigen::VectorXd>(rows.data(), 2 * count);
    sum += change * change.transpose() / kDraws;
  }
  const auto covariance = shiftCovariance(camera, places, pose, kSmoothness);
  ASSERT_TRUE(covariance);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR((*covariance)(k, k) / sum(k, k), 1.0, 0.1) << k;
}

TEST(ShiftField, AShiftOfAllIsAShiftOfThePose) {
  const CameraModel camera = CameraModel::raw(scene::calibration());
  const Eigen::Isometry3d pose = scene::upright({0.0, 0.0, 20.0}, 0.6);  // 3 px: the shift is the same at all places
  ShiftedPlaces places;
  places.add(0.1, Eigen::Isometry3d::Identity(), 0.2);
  const auto covariance = shiftCovariance(camera, places, pose, kSmoothness);
  ASSERT_TRUE(covariance);
  const double sideways = 0.2 * 20.0 / camera.fx();  // [m]
  EXPECT_NEAR(std::sqrt((*covariance)(0, 0)), sideways, 0.1 * sideways);
}
