#include "scene.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace scene {

seater_perception::Calibration calibration(double f, int width, int height) {
  seater_perception::Calibration c;
  c.width = width;
  c.height = height;
  c.K = {f, 0, 0.5 * (width - 1), 0, f, 0.5 * (height - 1), 0, 0, 1};
  c.D = {0, 0, 0, 0, 0};
  c.distortion_model = "plumb_bob";
  c.P = {f, 0, 0.5 * (width - 1), 0, 0, f, 0.5 * (height - 1), 0, 0, 0, 1, 0};
  return c;
}

Isometry3d upright(const Vector3d& position, double yaw, double pitch, double roll) {
  Eigen::Matrix3d facing;
  facing << 1, 0, 0, 0, -1, 0, 0, 0, -1;  // marker x right, y up, z towards the camera
  Isometry3d T = Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(roll, Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3d::UnitX()) *
               Eigen::AngleAxisd(yaw, -Vector3d::UnitY()) * facing;
  T.translation() = position;
  return T;
}

Isometry3d dockSeenFrom(double x, double y, double heading) {
  Isometry3d T_dock_base = Isometry3d::Identity();
  T_dock_base.linear() = Eigen::AngleAxisd(heading, Vector3d::UnitZ()).toRotationMatrix();
  T_dock_base.translation() = Vector3d(x, y, 0.0);
  Isometry3d T_base_optical = Isometry3d::Identity();
  T_base_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T_base_optical.translation() = Vector3d(0.45, 0.0, 0.70);
  return (T_dock_base * T_base_optical).inverse();
}

seater_perception::DockLayout defaultDock() {
  seater_perception::DockLayout layout;
  layout.family = seater_perception::MarkerFamily::named("DICT_4X4_50");
  layout.markers[0] = {0, 0.100, Vector3d(0.9, 0.0, 0.7), M_PI};
  layout.markers[1] = {1, 0.150, Vector3d(0.9, 0.35, 0.7), M_PI};
  layout.markers[2] = {2, 0.150, Vector3d(0.9, -0.35, 0.7), M_PI};
  return layout;
}

std::vector<Print> defaultPrints(const Isometry3d& T_optical_dock) {
  std::vector<Print> prints;
  const double sizes[] = {0.100, 0.150, 0.150}, ys[] = {0.0, 0.35, -0.35};
  for (int id = 0; id < 3; ++id) {
    Isometry3d T_dock_marker = Isometry3d::Identity();
    T_dock_marker.linear() << 0, 0, -1, -1, 0, 0, 0, 1, 0;
    T_dock_marker.translation() = Vector3d(0.9, ys[id], 0.7);
    prints.push_back({id, sizes[id], T_optical_dock * T_dock_marker});
  }
  return prints;
}

Vector2d pixelOf(const seater_perception::Calibration& c, const Vector3d& p) {
  const cv::Mat K(3, 3, CV_64F, const_cast<double*>(c.K.data()));
  const std::vector<cv::Point3d> points = {{p.x(), p.y(), p.z()}};
  std::vector<cv::Point2d> pixel;
  if (c.distortion_model == "equidistant") {
    cv::fisheye::projectPoints(points, pixel, cv::Vec3d(), cv::Vec3d(), K, c.D);
  } else {
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, c.D, pixel);
  }
  return {pixel[0].x, pixel[0].y};
}

std::vector<cv::Point2d> raysOf(const seater_perception::Calibration& c, const std::vector<cv::Point2d>& pixels) {
  const cv::Mat K(3, 3, CV_64F, const_cast<double*>(c.K.data()));
  const cv::TermCriteria stop(cv::TermCriteria::COUNT, 20, 0);
  std::vector<cv::Point2d> rays;
  if (c.distortion_model == "equidistant") {
    cv::fisheye::undistortPoints(pixels, rays, K, c.D);
  } else if (std::all_of(c.D.begin(), c.D.end(), [](double d) { return d == 0.0; })) {
    cv::undistortPoints(pixels, rays, K, cv::noArray());  // with coefficients of zero it would iterate for nothing
  } else {
    cv::undistortPoints(pixels, rays, K, c.D, cv::noArray(), cv::noArray(), stop);
  }
  return rays;
}

std::array<Vector2d, 4> trueCorners(const seater_perception::Calibration& c, const Print& print) {
  const double h = 0.5 * print.size;
  const Vector3d corners[] = {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
  std::array<Vector2d, 4> pixels;
  for (std::size_t i = 0; i < 4; ++i) pixels[i] = pixelOf(c, print.T_optical_marker * corners[i]);
  return pixels;
}

cv::Mat cellsOf(const seater_perception::MarkerPattern& pattern) {
  const int n = pattern.cells();
  cv::Mat cells(n, n, CV_8U);
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column)
      cells.at<uchar>(row, column) = static_cast<uchar>(255 * pattern.at(column, n - 1 - row));
  }
  return cells;
}

namespace {

/// Grey level of a ray; nothing (negative) when it misses the print and its white margin.
double greyOf(const cv::Mat& bits, const Print& print, const Isometry3d& T_marker_optical, const Vector2d& ray,
              const Look& look) {
  const Vector3d origin = T_marker_optical.translation();
  const Vector3d direction = T_marker_optical.linear() * Vector3d(ray.x(), ray.y(), 1.0);
  const double along = -origin.z() / direction.z();
  const Vector3d hit = origin + along * direction;
  const double cell = print.size / bits.cols;
  const double column = (hit.x() + 0.5 * print.size) / cell, row = (0.5 * print.size - hit.y()) / cell;
  if (along <= 0 || column < -1.5 || row < -1.5 || column > bits.cols + 1.5 || row > bits.rows + 1.5) return -1.0;
  if (column < 0 || row < 0 || column >= bits.cols || row >= bits.rows) return look.white;
  return bits.at<uchar>(static_cast<int>(row), static_cast<int>(column)) ? look.white : look.black;
}

/// Mean grey level of one pixel over its area; `rays` are those of its four corners (top left, top right, bottom left,
/// bottom right). Within a pixel rays change linearly, lens distortion or not.
template <typename Grey>
double meanOverPixel(const std::array<Vector2d, 4>& rays, double background, const Grey& grey) {
  const auto at = [&](double a, double b) {
    const double value = grey((1 - b) * ((1 - a) * rays[0] + a * rays[1]) + b * ((1 - a) * rays[2] + a * rays[3]));
    return value < 0 ? background : value;
  };
  const double first = at(0, 0);
  bool plain = true;
  for (int k = 1; plain && k < 9; ++k) plain = at(0.5 * (k % 3), 0.5 * (k / 3)) == first;
  if (plain) return first;
  constexpr int kSamples = 16;
  double sum = 0.0;
  for (int k = 0; k < kSamples * kSamples; ++k)
    sum += at((k % kSamples + 0.5) / kSamples, (k / kSamples + 0.5) / kSamples);
  return sum / (kSamples * kSamples);
}

/// Draws one print into an image of floating-point grey levels.
void drawPrint(const seater_perception::Calibration& c, const cv::Mat& bits, const Print& print, const Look& look,
               cv::Mat& image) {
  std::vector<cv::Point2f> outline;
  for (const auto& p : trueCorners(c, print)) outline.emplace_back(p.x(), p.y());
  cv::Rect box = cv::boundingRect(outline);
  const int margin = std::max(box.width, box.height) / 2 + 4;
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect(0, 0, c.width, c.height);
  if (box.empty()) return;
  std::vector<cv::Point2d> grid;  // the corners of the pixels
  for (int y = 0; y <= box.height; ++y) {
    for (int x = 0; x <= box.width; ++x) grid.emplace_back(box.x + x - 0.5, box.y + y - 0.5);
  }
  const std::vector<cv::Point2d> rays = raysOf(c, grid);
  const Isometry3d T_marker_optical = print.T_optical_marker.inverse();
  const auto grey = [&](const Vector2d& ray) { return greyOf(bits, print, T_marker_optical, ray, look); };
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const std::size_t k = static_cast<std::size_t>(y * (box.width + 1) + x), below = k + box.width + 1;
      const auto ray = [&](std::size_t i) { return Vector2d(rays[i].x, rays[i].y); };
      auto& pixel = image.at<float>(box.y + y, box.x + x);
      pixel = static_cast<float>(meanOverPixel({ray(k), ray(k + 1), ray(below), ray(below + 1)}, pixel, grey));
    }
  }
}

}  // namespace

cv::Mat draw(const seater_perception::Calibration& c, const seater_perception::MarkerFamily& family,
             const std::vector<Print>& prints, const Look& look, unsigned seed) {
  cv::Mat image(c.height, c.width, CV_32F, cv::Scalar(look.wall));
  for (const Print& print : prints) drawPrint(c, cellsOf(family.pattern(print.id)), print, look, image);
  if (look.blur > 0) cv::GaussianBlur(image, image, cv::Size(), look.blur);
  cv::RNG random(seed);
  cv::Mat noise(image.size(), CV_32F);
  random.fill(noise, cv::RNG::NORMAL, 0.0, look.noise);
  if (look.noise > 0) image += noise;
  cv::Mat grey;
  image.convertTo(grey, CV_8U);
  return grey;
}

cv::Mat draw(const seater_perception::Calibration& c, const std::string& dictionary, const std::vector<Print>& prints,
             const Look& look, unsigned seed) {
  return draw(c, seater_perception::MarkerFamily::named(dictionary), prints, look, seed);
}

}  // namespace scene
