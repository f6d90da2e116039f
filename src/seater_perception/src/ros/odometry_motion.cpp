#include "odometry_motion.h"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cstdint>
#include <limits>
#include <utility>

namespace seater_perception {
namespace {

constexpr std::uint32_t kEnd = std::numeric_limits<std::int32_t>::max() - 10;  // [s] TF adds ten to it

}  // namespace

int TransformInput::take(const ros::Time& now, const std::vector<geometry_msgs::TransformStamped>& transforms,
                         const std::string& authority, bool fixed) {
  if (now < last_) buffer_.clear();
  last_ = now;
  int refused = 0;
  for (geometry_msgs::TransformStamped transform : transforms) {
    if (fixed) transform.header.stamp = ros::Time();  // it does not count
    if (transform.header.stamp.sec >= kEnd) {
      ++refused;
      continue;
    }
    try {
      buffer_.setTransform(transform, authority, fixed);  // says itself what it does not take
    } catch (const std::exception&) {
      ++refused;
    }
  }
  return refused;
}

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
  } catch (const std::exception&) {  // a stamp, too, that TF cannot represent
    return std::nullopt;
  }
}

}  // namespace seater_perception
