#include "odometry_motion.h"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <utility>

namespace seater_perception {

OdometryMotion::OdometryMotion(const tf2::BufferCore& buffer, std::string odometry_frame)
    : buffer_(buffer), odometry_frame_(std::move(odometry_frame)) {}

std::optional<Eigen::Isometry3d> OdometryMotion::next(const std::string& optical_frame, const ros::Time& stamp) {
  const ros::Time last = std::exchange(last_stamp_, stamp);
  const std::string last_frame = std::exchange(last_frame_, optical_frame);
  // A zero time would mean the newest transform.
  if (last.isZero() || stamp <= last || optical_frame.empty() || optical_frame != last_frame) return std::nullopt;
  try {
    const Eigen::Isometry3d motion =
        tf2::transformToEigen(buffer_.lookupTransform(optical_frame, stamp, optical_frame, last, odometry_frame_));
    return motion.matrix().allFinite() ? std::optional<Eigen::Isometry3d>(motion) : std::nullopt;
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

}  // namespace seater_perception
