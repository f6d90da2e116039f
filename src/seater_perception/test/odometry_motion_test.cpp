// The camera's motion out of TF, without a ROS master.

#include "../src/ros/odometry_motion.h"

#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

using namespace seater_perception;

namespace {

const char* const kOptical = "camera_color_optical_frame";

void set(tf2::BufferCore& buffer, const char* parent, const char* child, const Eigen::Isometry3d& pose, double stamp,
         bool fixed = false) {
  geometry_msgs::TransformStamped message = tf2::eigenToTransform(pose);
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.header.stamp = ros::Time(stamp);
  buffer.setTransform(message, "test", fixed);
}

Eigen::Isometry3d baseAt(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, 0.0);
  return T;
}

Eigen::Isometry3d mount() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T.translation() = Eigen::Vector3d(0.45, 0.0, 0.70);
  return T;
}

/// Drives at 0.5 m/s and turns by 1 rad/s from t = 10 s on.
void fill(tf2::BufferCore& buffer, double until) {
  set(buffer, "base_link", kOptical, mount(), 0.0, true);
  for (double t = 10.0; t < until + 1e-9; t += 0.01) {
    set(buffer, "odom", "base_link", baseAt(0.5 * (t - 10), 0.0, t - 10), t);
  }
}

}  // namespace

TEST(TransformInput, noStampEndsTheProcessOrKeepsLaterTransformsOut) {
  tf2::BufferCore buffer;
  TransformInput input(buffer);
  const auto stamped = [](ros::Time stamp, const char* parent, const char* child, const Eigen::Isometry3d& pose) {
    geometry_msgs::TransformStamped message = tf2::eigenToTransform(pose);
    message.header.frame_id = parent;
    message.child_frame_id = child;
    message.header.stamp = stamp;
    return message;
  };
  const ros::Time now(1000.0);
  for (const ros::Time& stamp :
       {ros::Time(0, 0), ros::Time(1, 0), ros::Time(2147483647, 0), ros::Time(4294967295u, 999999999)}) {
    const int refused = input.take(now, {stamped(stamp, "odom", "base_link", baseAt(9.0, 9.0, 1.0))}, "test", false);
    EXPECT_EQ(refused, stamp.sec > 1 ? 1 : 0);
    EXPECT_EQ(input.take(now, {stamped(stamp, "base_link", kOptical, mount())}, "test", true), 0);
  }
  OdometryMotion motion(buffer, "odom");
  for (double t : {1000.0, 1000.1}) {
    EXPECT_EQ(
        input.take(now, {stamped(ros::Time(t), "odom", "base_link", baseAt(t - 1000.0, 0.0, 0.0))}, "test", false), 0);
    EXPECT_EQ(motion.next(kOptical, ros::Time(t)).has_value(), t > 1000.0);
  }
  EXPECT_FALSE(motion.next(kOptical, ros::Time(4294967295u, 0)));
}

TEST(TransformInput, aClockThatGoesBackwardBeginsAnew) {
  tf2::BufferCore buffer;
  fill(buffer, 10.2);
  TransformInput input(buffer);
  input.take(ros::Time(2000.0), {}, "test", false);
  EXPECT_TRUE(buffer._frameExists("odom"));
  input.take(ros::Time(1000.0), {}, "test", false);
  EXPECT_FALSE(buffer.canTransform("odom", "base_link", ros::Time(10.1)));
}

TEST(OdometryMotion, isThePoseOfTheLastImageInThisOne) {
  tf2::BufferCore buffer;
  fill(buffer, 10.2);
  OdometryMotion motion(buffer, "odom");
  EXPECT_FALSE(motion.next(kOptical, ros::Time(10.0))) << "there is no last image";
  const auto found = motion.next(kOptical, ros::Time(10.1));
  ASSERT_TRUE(found);
  const Eigen::Isometry3d expected = (baseAt(0.05, 0.0, 0.1) * mount()).inverse() * baseAt(0.0, 0.0, 0.0) * mount();
  EXPECT_LT((found->matrix() - expected.matrix()).norm(), 1e-6);
  // What stood straight ahead is to the right now (x > 0), as the chair turned left.
  EXPECT_GT((*found * Eigen::Vector3d(0, 0, 2)).x(), 0.1);
}

TEST(OdometryMotion, whatTfDoesNotKnowIsNotUsed) {
  tf2::BufferCore buffer;
  OdometryMotion without(buffer, "odom");
  EXPECT_FALSE(without.next(kOptical, ros::Time(10.0)));
  EXPECT_FALSE(without.next(kOptical, ros::Time(10.1))) << "TF is empty";
  fill(buffer, 10.2);
  OdometryMotion motion(buffer, "odom");
  EXPECT_FALSE(motion.next(kOptical, ros::Time(10.1)));
  EXPECT_FALSE(motion.next(kOptical, ros::Time(10.3))) << "odometry has not come so far";
  EXPECT_FALSE(motion.next(kOptical, ros::Time(10.2))) << "the clock went back";
  EXPECT_FALSE(motion.next("other", ros::Time(10.2)));
  EXPECT_FALSE(motion.next("", ros::Time(10.2)));
  OdometryMotion wrong(buffer, "map");
  wrong.next(kOptical, ros::Time(10.0));
  EXPECT_FALSE(wrong.next(kOptical, ros::Time(10.1)));
}

TEST(OdometryMotion, afterAResetThereIsNoLastImage) {
  tf2::BufferCore buffer;
  fill(buffer, 10.2);
  OdometryMotion motion(buffer, "odom");
  motion.next(kOptical, ros::Time(10.0));
  motion.reset();
  EXPECT_FALSE(motion.next(kOptical, ros::Time(10.1)));
  EXPECT_TRUE(motion.next(kOptical, ros::Time(10.2)));
}
