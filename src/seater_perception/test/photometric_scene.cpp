#include "photometric_scene.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace photo_scene {

View moved(const View& setup, const Vector6d& change) {
  View result = setup;
  const Vector3d w = change.tail<3>();
  if (w.norm() > 0) result.pose.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()) * setup.pose.linear();
  result.pose.translation() += change.head<3>();
  for (auto& print : result.prints)
    print.T_optical_marker = result.pose * setup.pose.inverse() * print.T_optical_marker;
  return result;
}

cv::Rect boxOf(const View& setup, const scene::Print& print, double margin, int cells) {
  const double h = print.size * (0.5 + margin / cells);
  std::vector<cv::Point2f> outline;
  for (const auto& c : {Vector3d(-h, h, 0), Vector3d(h, h, 0), Vector3d(h, -h, 0), Vector3d(-h, -h, 0)}) {
    const Vector2d p = scene::pixelOf(setup.camera, print.T_optical_marker * c);
    outline.emplace_back(p.x(), p.y());
  }
  return cv::boundingRect(outline) & cv::Rect(0, 0, setup.camera.width, setup.camera.height);
}
namespace {

cv::Mat bitsOf(const scene::Print& print) {
  const auto dict = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  cv::Mat bits;
  dict->drawMarker(print.id, dict->markerSize + 2, bits, 1);
  return bits;
}

/// Share of white, 0..1, of every pixel of the box (CV_64F); the sheet has no end.
cv::Mat whiteShare(const View& setup, const scene::Print& print, const cv::Rect& box) {
  const int s = setup.samples;
  const int border = static_cast<int>(std::ceil(4.0 * setup.blur + 0.5 * setup.motion.norm())) + 1;
  const int columns = (box.width + 2 * border) * s, rows = (box.height + 2 * border) * s;
  const cv::Mat K(3, 3, CV_64F, const_cast<double*>(setup.camera.K.data()));
  const cv::Mat bits = bitsOf(print);
  const Isometry3d inverse = print.T_optical_marker.inverse();
  const double cell = print.size / bits.cols;
  const bool lens = setup.camera.distortion_model == "equidistant" ||
                    std::any_of(setup.camera.D.begin(), setup.camera.D.end(), [](double d) { return d != 0.0; });
  cv::Mat fine(rows, columns, CV_32F);
  const auto white = [&](int column, int row) {  // row from the top
    if (column < 0 || row < 0 || column >= bits.cols || row >= bits.rows) return 1.0;
    return bits.at<uchar>(row, column) ? 1.0 : 0.0;
  };
  const auto cells = [&](const Vector2d& ray) {
    const Vector3d d = inverse.linear() * Vector3d(ray.x(), ray.y(), 1.0), o = inverse.translation();
    const Vector3d hit = o - o.z() / d.z() * d;
    return Vector2d((hit.x() + 0.5 * print.size) / cell, (0.5 * print.size - hit.y()) / cell);
  };
  std::vector<cv::Point2d> pixels(static_cast<std::size_t>(columns)), rays;
  std::vector<Vector2d> above(pixels.size()), here(pixels.size());
  for (int r = -1; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      pixels[static_cast<std::size_t>(c)] = {box.x - border - 0.5 + (c + 0.5) / s,
                                             box.y - border - 0.5 + (r + 0.5) / s};
    }
    rays = pixels;
    if (lens) {
      rays = scene::raysOf(setup.camera, pixels);
    } else {
      for (auto& p : rays)
        p = {(p.x - K.at<double>(0, 2)) / K.at<double>(0, 0), (p.y - K.at<double>(1, 2)) / K.at<double>(1, 1)};
    }
    above = here;
    for (std::size_t c = 0; c < here.size(); ++c) here[c] = cells({rays[c].x, rays[c].y});
    if (r < 0) continue;
    for (std::size_t c = 0; c < here.size(); ++c) {
      // A border that crosses the fine square is felt in proportion.
      const Vector2d right = here[std::min(c + 1, here.size() - 1)] - here[c == 0 ? 0 : c - 1],
                     down = here[c] - above[c];
      const double n = (c == 0 || c + 1 == here.size()) ? 1.0 : 2.0;
      const double wx = std::max(std::abs(right.x()) / n, std::abs(down.x()));
      const double wy = std::max(std::abs(right.y()) / n, std::abs(down.y()));
      const int x = static_cast<int>(std::lround(here[c].x())), y = static_cast<int>(std::lround(here[c].y()));
      const double bx = std::clamp(0.5 + (here[c].x() - x) / wx, 0.0, 1.0);
      const double by = std::clamp(0.5 + (here[c].y() - y) / wy, 0.0, 1.0);
      fine.at<float>(r, static_cast<int>(c)) =
          static_cast<float>((1 - by) * ((1 - bx) * white(x - 1, y - 1) + bx * white(x, y - 1)) +
                             by * ((1 - bx) * white(x - 1, y) + bx * white(x, y)));
    }
  }
  if (setup.blur > 0) {
    cv::GaussianBlur(fine, fine, cv::Size(), setup.blur * s, setup.blur * s, cv::BORDER_REPLICATE);
  }
  if (setup.motion.norm() > 0) {
    const int steps = static_cast<int>(std::ceil(2.0 * setup.motion.norm() * s));
    cv::Mat sum = cv::Mat::zeros(fine.size(), CV_32F), shifted;
    for (int i = 0; i < steps; ++i) {
      const double t = ((i + 0.5) / steps - 0.5) * s;
      const cv::Matx23d shift(1, 0, t * setup.motion.x(), 0, 1, t * setup.motion.y());
      cv::warpAffine(fine, shifted, shift, fine.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
      sum += shifted / steps;
    }
    fine = sum;
  }
  cv::Mat share(box.height, box.width, CV_64F);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      share.at<double>(y, x) = cv::mean(fine(cv::Rect((x + border) * s, (y + border) * s, s, s)))[0];
    }
  }
  return share;
}

}  // namespace

cv::Mat clean(const View& setup) {
  cv::Mat image(setup.camera.height, setup.camera.width, CV_64F, cv::Scalar(setup.white));
  for (const auto& print : setup.prints) {
    const cv::Rect box = boxOf(setup, print, 1.6, 6);
    cv::Mat(setup.black + (setup.white - setup.black) * whiteShare(setup, print, box)).copyTo(image(box));
  }
  return image;
}

cv::Mat withNoise(const cv::Mat& clean, double sd, unsigned seed, int type) {
  cv::RNG random(seed * 7919u + 17u);
  cv::Mat noise(clean.size(), CV_64F), result;
  random.fill(noise, cv::RNG::NORMAL, 0.0, std::max(sd, 1e-12));
  cv::Mat(clean + noise).convertTo(result, type);
  return result;
}

Bound cramerRao(const View& setup, double noise, bool blur, bool slopes) {
  const int shared = 6 + (blur ? 1 : 0), own = slopes ? 4 : 2;
  const int n = shared + own * static_cast<int>(setup.prints.size());
  // Turned about the middle of the prints: about a far origin, no step would be short enough.
  Vector3d middle = Vector3d::Zero();
  for (const auto& print : setup.prints) middle += print.T_optical_marker.translation() / setup.prints.size();
  const Vector3d arm = setup.pose.translation() - middle;
  const double turn = setup.prints.size() > 1 ? 0.002 : 0.02;
  cv::Mat_<double> information = cv::Mat_<double>::zeros(n, n);
  for (std::size_t k = 0; k < setup.prints.size(); ++k) {
    const cv::Rect box = boxOf(setup, setup.prints[k], 1.0, 6);
    const double f = setup.camera.K[0], contrast = setup.white - setup.black;
    std::vector<cv::Mat> J(static_cast<std::size_t>(n));
    for (cv::Mat& j : J) j = cv::Mat::zeros(box.size(), CV_64F);
    for (int i = 0; i < 6; ++i) {
      const double step = 0.05 * setup.pose.translation().z() / f;  // a twentieth of a pixel
      Vector6d change = Vector6d::Zero();
      change[i] = i < 2 ? step : i == 2 ? step * 8.0 : i < 5 ? turn : 0.2 * turn;
      const double size = change[i];
      const auto at = [&](double sign) {
        Vector6d about = sign * change;
        const Vector3d w = about.tail<3>();
        if (i > 2) about.head<3>() += Eigen::AngleAxisd(w.norm(), w.normalized()) * arm - arm;
        const View there = moved(setup, about);
        return whiteShare(there, there.prints[k], box);
      };
      J[static_cast<std::size_t>(i)] = (at(1.0) - at(-1.0)) * (contrast / (2.0 * size));
    }
    if (blur) {
      View wide = setup, narrow = setup;
      wide.blur += 0.02, narrow.blur -= 0.02;
      J[6] = (whiteShare(wide, setup.prints[k], box) - whiteShare(narrow, setup.prints[k], box)) * (contrast / 0.04);
    }
    const std::size_t first = static_cast<std::size_t>(shared) + k * static_cast<std::size_t>(own);
    const cv::Mat share = whiteShare(setup, setup.prints[k], box);
    J[first] = cv::Mat::ones(box.size(), CV_64F);
    J[first + 1] = share;
    if (slopes) {
      for (int y = 0; y < box.height; ++y) {
        for (int x = 0; x < box.width; ++x) {
          const double grey = setup.black + contrast * share.at<double>(y, x);
          J[first + 2].at<double>(y, x) = grey * (2.0 * x / box.width - 1.0);
          J[first + 3].at<double>(y, x) = grey * (2.0 * y / box.height - 1.0);
        }
      }
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        information(i, j) += J[static_cast<std::size_t>(i)].dot(J[static_cast<std::size_t>(j)]);
    }
  }
  // Metres, radians and grey levels differ by orders of magnitude: inverted scaled to a unit diagonal.
  cv::Mat scale;
  cv::sqrt(information.diag(), scale);
  const cv::Mat scales = scale * scale.t();
  const cv::Mat_<double> inverse = cv::Mat(information / scales).inv() / scales;
  Eigen::Matrix<double, 6, 6> pose, A = Eigen::Matrix<double, 6, 6>::Identity();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) pose(i, j) = inverse(i, j);
  }
  A.topRightCorner<3, 3>() << 0.0, arm.z(), -arm.y(), -arm.z(), 0.0, arm.x(), arm.y(), -arm.x(), 0.0;
  return {noise * noise * A * pose * A.transpose()};
}

Vector6d errorOf(const Isometry3d& estimate, const Isometry3d& truth) {
  Vector6d e;
  const Eigen::AngleAxisd turn(truth.linear() * estimate.linear().transpose());
  e << truth.translation() - estimate.translation(), turn.angle() * turn.axis();
  return e;
}

View single(double size, double distance, double yaw, double pitch, double roll) {
  View setup;
  setup.pose = scene::upright(Vector3d(0.0313 * distance, -0.0217 * distance, distance), yaw, pitch, roll);
  setup.prints = {{0, size, setup.pose}};
  setup.samples = distance < 1.5 ? 6 : 12;
  return setup;
}

Isometry3d initialNear(const View& setup, std::mt19937& random, double pixels, double depth, double turn) {
  std::normal_distribution<double> n;
  const double lateral = pixels * setup.pose.translation().z() / setup.camera.K[0];
  Vector6d change;
  change << lateral * n(random), lateral * n(random), depth * setup.pose.translation().z() * n(random),
      turn * n(random), turn * n(random), 0.3 * turn * n(random);
  // Turned about the middle of the prints, which may be far from the object's origin.
  Vector3d middle = Vector3d::Zero();
  for (const auto& print : setup.prints) middle += print.T_optical_marker.translation() / setup.prints.size();
  const Vector3d w = change.tail<3>(), arm = setup.pose.translation() - middle;
  change.head<3>() += Eigen::AngleAxisd(w.norm(), w.normalized()) * arm - arm;
  return moved(setup, change).pose;
}

}  // namespace photo_scene
