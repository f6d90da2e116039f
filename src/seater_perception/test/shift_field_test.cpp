// Smooth shifts of the image: how large they are by what fits have left over, and what they do to a pose.

#include "pose/shift_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "numerics/solve.h"
#include "numerics/symmetric.h"
#include "scene.h"
#include "seater_perception/photometric.h"

using namespace seater_perception;

namespace {

constexpr double kUsual = 0.1;  // [px]

/// What markers leave over of a field of this variance [px^2]: modes from hardly informative to very much so.
ShiftEvidence drawn(double variance, double most, std::mt19937& random) {
  std::normal_distribution<double> normal;
  ShiftEvidence evidence;
  for (std::size_t k = 0; k < evidence.information.size(); ++k) {
    const double i = most * std::pow(0.6, static_cast<double>(k)), value = normal(random);
    evidence.information[k] = i;
    evidence.square[k] = value * value * (i + variance * i * i);
  }
  return evidence;
}

void add(const ShiftEvidence& evidence, double weight, ShiftField& field) {
  for (std::size_t k = 0; k < evidence.square.size(); ++k)
    field.add(evidence.information[k], evidence.square[k], weight);
}

double meanVariance(double variance, double most, double usual) {
  std::mt19937 random(3);
  constexpr int kImages = 200;
  double sum = 0.0;
  for (int i = 0; i < kImages; ++i) {
    ShiftField field;
    for (int marker = 0; marker < 3; ++marker) add(drawn(variance, most, random), 1.0, field);
    sum += field.variance(usual) / kImages;
  }
  return sum;
}

}  // namespace

TEST(ShiftField, ComesOutOfWhatIsLeftOver) {
  for (const double sigma : {0.05, 0.1, 0.3}) {
    const double variance = meanVariance(sigma * sigma, 1e5, kUsual);
    EXPECT_GT(variance, sigma * sigma) << sigma;  // with a margin
    EXPECT_LT(variance, 1.7 * sigma * sigma) << sigma;
  }
}

TEST(ShiftField, NoneIsSeenWhereMarkersWouldShowIt) {
  EXPECT_LT(std::sqrt(meanVariance(0.0, 1e8, kUsual)), 0.01);
}

TEST(ShiftField, IsTheUsualOneWhereNothingTells) {
  EXPECT_GT(ShiftField().variance(kUsual), kUsual * kUsual);  // with a margin, as all estimates
  EXPECT_LT(ShiftField().variance(kUsual), 2.5 * kUsual * kUsual);
  EXPECT_DOUBLE_EQ(ShiftField().variance(0.0), 0.0);
  EXPECT_GT(std::sqrt(meanVariance(0.0, 1.0, kUsual)), 0.9 * kUsual);  // a mode's noise is 1 px
}

TEST(ShiftField, OthersCountByTheirWeight) {
  std::mt19937 random(4);
  ShiftField own, heavy, light;
  const ShiftEvidence quiet = drawn(0.0, 1e5, random), moved = drawn(0.09, 1e5, random);
  for (ShiftField* field : {&own, &heavy, &light}) add(quiet, 1.0, *field);
  add(moved, 1.0, heavy);
  add(moved, 0.01, light);
  EXPECT_LT(own.variance(kUsual), light.variance(kUsual));
  EXPECT_LT(light.variance(kUsual), heavy.variance(kUsual));
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
      alike(i, k) = std::exp(-(seen[i] - seen[k]).squaredNorm() / (4.0 * kUsualSmoothness * kUsualSmoothness));
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
  const auto covariance = shiftCovariance(camera, places, pose);
  ASSERT_TRUE(covariance);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR((*covariance)(k, k) / sum(k, k), 1.0, 0.1) << k;
}

TEST(ShiftField, AShiftOfAllIsAShiftOfThePose) {
  const CameraModel camera = CameraModel::raw(scene::calibration());
  const Eigen::Isometry3d pose = scene::upright({0.0, 0.0, 20.0}, 0.6);  // 3 px: the shift is the same at all places
  ShiftedPlaces places;
  places.add(0.1, Eigen::Isometry3d::Identity(), 0.2);
  const auto covariance = shiftCovariance(camera, places, pose);
  ASSERT_TRUE(covariance);
  const double sideways = 0.2 * 20.0 / camera.fx();  // [m]
  EXPECT_NEAR(std::sqrt((*covariance)(0, 0)), sideways, 0.1 * sideways);
}
