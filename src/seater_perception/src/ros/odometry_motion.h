#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

namespace seater_perception {

/// Takes transforms into a buffer. tf2_ros' own listener ends the whole process at a stamp that TF cannot add its ten
/// seconds to.
class TransformInput {
 public:
  /// The buffer has to outlive this.
  explicit TransformInput(tf2::BufferCore& buffer) : buffer_(buffer) {}

  /// At `now` of the ROS clock; where that has gone backward, what came before is forgotten. `fixed`: of /tf_static.
  /// Returns how many were refused.
  int take(const ros::Time& now, const std::vector<geometry_msgs::TransformStamped>& transforms,
           const std::string& authority, bool fixed);

 private:
  tf2::BufferCore& buffer_;
  ros::Time last_;
};

/// How the camera moved between two images, by the odometry that TF holds. Never waits: what TF does not know when an
/// image is here is not used. Remembers the last image's stamp; not thread-safe (the buffer is).
class OdometryMotion {
 public:
  /// `odometry_frame`: continuous frame (`odom`). The buffer has to outlive this.
  OdometryMotion(const tf2::BufferCore& buffer, std::string odometry_frame);

  /// To be called for each image: pose of the last image's optical frame in this one's (T_now_last), looked up at
  /// both images' own stamps. Nothing for the first image, another optical frame, a stamp that is not later, and
  /// when TF does not reach from one to the other.
  std::optional<Eigen::Isometry3d> next(const std::string& optical_frame, const ros::Time& stamp);

  /// The next image is a first one.
  void reset() { last_stamp_ = ros::Time(); }

 private:
  const tf2::BufferCore& buffer_;
  std::string odometry_frame_;
  std::string last_frame_;
  ros::Time last_stamp_;
};

}  // namespace seater_perception
