#include "marker/marker_plane.h"

namespace seater_perception {

MarkerPlane::MarkerPlane(const Eigen::Isometry3d& pose)
    : r1_(pose.linear().col(0)), r2_(pose.linear().col(1)), r3_(pose.linear().col(2)) {
  t1_ = r1_.dot(pose.translation());
  t2_ = r2_.dot(pose.translation());
  t3_ = r3_.dot(pose.translation());
}

bool MarkerPlane::hit(const PixelRay& ray, MarkerHit& hit) const {
  const double inverse = 1.0 / (r3_.x() * ray.x + r3_.y() * ray.y + r3_.z()), depth = t3_ * inverse;
  if (!(depth > 1e-6 && depth < 1e6)) return false;
  const double alpha = (r1_.x() * ray.x + r1_.y() * ray.y + r1_.z()) * inverse;
  const double beta = (r2_.x() * ray.x + r2_.y() * ray.y + r2_.z()) * inverse;
  hit.x = t3_ * alpha - t1_;
  hit.y = t3_ * beta - t2_;
  const double x0 = depth * (r1_.x() - alpha * r3_.x()), x1 = depth * (r1_.y() - alpha * r3_.y());
  const double y0 = depth * (r2_.x() - beta * r3_.x()), y1 = depth * (r2_.y() - beta * r3_.y());
  hit.gxu = x0 * ray.x_by_u + x1 * ray.y_by_u;
  hit.gxv = x0 * ray.x_by_v + x1 * ray.y_by_v;
  hit.gyu = y0 * ray.x_by_u + y1 * ray.y_by_u;
  hit.gyv = y0 * ray.x_by_v + y1 * ray.y_by_v;
  return true;
}

}  // namespace seater_perception
