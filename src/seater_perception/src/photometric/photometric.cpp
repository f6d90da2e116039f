#include "seater_perception/photometric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "photometric/seed_fit.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

constexpr double kFineMargin = 0.25;    // [px] the approach ends nearer than this
constexpr double kNoEnd = 1e6;          // [grey levels] of a sensor that does not clip
constexpr int kSparse = 1000;           // pixels of an approach
constexpr double kClearlyWorse = 30.0;  // of chi-squared: beyond all doubt
constexpr int kRounds = 4;              // of collecting pixels: the approach, then again while a marker leaves its band

using Blur = PhotometricProblem::Blur;
using Placements = std::vector<PatternPlacement>;

Blur blurOf(const std::string& name) {
  if (name == "given") return Blur::given;
  if (name == "estimated") return Blur::round;
  if (name == "directed") return Blur::directed;
  throw ConfigurationError("photometric/blur: is '" + name + "', must be given, estimated or directed");
}

/// Largest movement of a marker's corner in the image [px], and in sides of the marker; infinite when behind the
/// camera.
double movement(const CameraModel& camera, const Placements& placements, const Eigen::Isometry3d& a,
                const Eigen::Isometry3d& b, double& sides) {
  double largest = 0.0;
  sides = 0.0;
  for (const PatternPlacement& p : placements) {
    std::optional<Eigen::Vector2d> previous;
    double moved = 0.0, side = 0.0;
    for (const Eigen::Vector3d& corner : markerCorners(p.size)) {
      const auto from = camera.project(a * p.T_object_marker * corner),
                 to = camera.project(b * p.T_object_marker * corner);
      if (!from || !to) return sides = std::numeric_limits<double>::infinity();
      moved = std::max(moved, (*from - *to).norm());
      if (previous) side = std::max(side, (*from - *previous).norm());
      previous = from;
    }
    largest = std::max(largest, moved);
    sides = std::max(sides, moved / std::max(1e-6, side));
  }
  return largest;
}

/// Fills in the rest of the result, or takes everything back when it cannot be relied on.
void conclude(const CameraModel& camera, const Placements& placements, const PhotometricParameters& parameters,
              const Eigen::Isometry3d& seed, SeedFit& fit) {
  PhotometricResult& result = fit.result;
  double sides = 0.0;
  movement(camera, placements, seed, fit.state.pose, sides);
  if (!fit.failed && !(sides < parameters.max_shift)) fit.fail("moved too far from the seed");
  if (!fit.failed && result.inlier_share < parameters.min_inlier_share) fit.fail("too few inliers");
  for (const Brightness& b : fit.state.brightness) {
    if (!fit.failed && b.used && b.gain < parameters.min_contrast) fit.fail("too little contrast");
  }
  const SpreadCovariance& s = fit.state.blur;
  const double mean = 0.5 * (s.uu + s.vv), half = std::hypot(0.5 * (s.uu - s.vv), s.uv), area = areaVariance(1);
  result.blur_sd = std::sqrt(std::sqrt(std::max(0.0, mean + half) * std::max(0.0, mean - half)));
  result.blur_elongation = std::sqrt((mean + half + area) / std::max(1e-3, mean - half + area));
  const bool finite = fit.state.pose.matrix().allFinite() && result.covariance.allFinite() &&
                      std::isfinite(result.noise_sd + result.blur_sd + result.blur_elongation);
  if (!fit.failed && !finite) fit.fail("not finite");
  if (fit.failed) {
    PhotometricResult nothing;
    nothing.failure = result.failure;
    nothing.iterations = result.iterations;
    nothing.pose = seed;
    nothing.brightness.assign(placements.size(), {});
    result = nothing;
    return;
  }
  result.converged = true;
  result.pose = fit.state.pose;
  result.pose.linear() = Eigen::Quaterniond(fit.state.pose.linear()).normalized().toRotationMatrix();
  result.brightness = fit.state.brightness;
}

void requireImage(const cv::Mat& grey, const CameraModel& camera) {
  if (grey.type() != CV_8UC1 && grey.type() != CV_16UC1) throw ImageError("image: must be CV_8UC1 or CV_16UC1");
  if (grey.cols != camera.width() || grey.rows != camera.height()) {
    throw ImageError("image: is " + std::to_string(grey.cols) + " x " + std::to_string(grey.rows) + ", must be " +
                     std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
  }
}

double blurSd(const PhotometricState& state) {
  return std::sqrt(std::max(0.0, 0.5 * (state.blur.uu + state.blur.vv)));
}

}  // namespace

struct PhotometricRefiner::Workspace {
  SampleCollector collector;
  PhotometricProblem problem;
  std::vector<MarkerSamples> samples;

  /// Pixels of all markers, the same for all fits; returns the widest blur of the fits, for which they are meant [px].
  double collectAll(const PhotometricParameters& parameters, const cv::Mat& grey, const CameraModel& camera,
                    const Placements& placements, const std::vector<SeedFit>& fits, double margin, int most, bool rim) {
    double blur = 0.0, sides = 0.0, apart = 0.0;
    const SeedFit* first = nullptr;
    for (const SeedFit& fit : fits) {
      if (fit.failed) continue;
      if (!first) first = &fit;
      blur = std::max(blur, blurSd(fit.state));
      apart = std::max(apart, movement(camera, placements, first->state.pose, fit.state.pose, sides));
    }
    samples.resize(placements.size());
    for (std::size_t m = 0; m < placements.size(); ++m) {
      samples[m].clear();
      if (first) {
        collector.collect(grey, camera, placements[m], first->state.pose * placements[m].T_object_marker, blur,
                          margin + apart, most, rim, parameters, samples[m]);
      }
    }
    return blur;
  }

  /// All fits from where they are to their minima; those that cannot win end at the first look.
  void finishAll(std::vector<SeedFit>& fits, bool begin, const std::optional<Brightness>& known) {
    const SeedFit* best = nullptr;
    for (SeedFit& fit : fits) {
      if (fit.failed) continue;
      if (known) {
        if (begin) fit.start(problem, *known, best);
        if (!fit.failed) fit.finish(problem);
        if (!fit.failed && !best) best = &fit;
        continue;
      }
      if (begin) fit.start(problem);
      if (!fit.failed) fit.firstLook(problem);
      if (!fit.failed && best && fit.clearlyWorseThan(*best)) {
        fit.hopeless = true;
        fit.fail("clearly worse than another seed's");
      }
      if (!fit.failed && best && fit.sameAs(*best, problem)) fit.fail("same as another seed's");
      if (!fit.failed) fit.finish(problem);
      if (!fit.failed && !best) best = &fit;
    }
  }

  std::vector<SeedFit> fitAll(const PhotometricParameters& parameters, const cv::Mat& grey, const CameraModel& camera,
                              const Placements& placements, const std::vector<Eigen::Isometry3d>& seeds,
                              const PhotometricStart& start);
  std::vector<SeedFit> fitClipped(const PhotometricParameters& parameters, const cv::Mat& grey,
                                  const CameraModel& camera, const Placements& placements,
                                  const std::vector<Eigen::Isometry3d>& seeds, const PhotometricStart& start,
                                  const ClipRange& range);
};

/// A drawn image may have no grey level between black and white, both at the sensor's ends. To say that all of it is
/// clipped explains it best, and tells nothing of the pose: then without clipping.
std::vector<SeedFit> PhotometricRefiner::Workspace::fitAll(const PhotometricParameters& parameters, const cv::Mat& grey,
                                                           const CameraModel& camera, const Placements& placements,
                                                           const std::vector<Eigen::Isometry3d>& seeds,
                                                           const PhotometricStart& start) {
  requireImage(grey, camera);
  const double limit = parameters.saturation > 0.0 ? parameters.saturation : grey.depth() == CV_16U ? 65535.0 : 255.0;
  auto fits = fitClipped(parameters, grey, camera, placements, seeds, start, {0.0, limit});
  const bool blind = std::any_of(fits.begin(), fits.end(), [](const SeedFit& fit) { return fit.failed && fit.blind; });
  const bool none = std::all_of(fits.begin(), fits.end(), [](const SeedFit& fit) { return fit.failed; });
  if (blind && none) fits = fitClipped(parameters, grey, camera, placements, seeds, start, {-kNoEnd, kNoEnd});
  return fits;
}

/// All seeds on the same pixels.
std::vector<SeedFit> PhotometricRefiner::Workspace::fitClipped(const PhotometricParameters& parameters,
                                                               const cv::Mat& grey, const CameraModel& camera,
                                                               const Placements& placements,
                                                               const std::vector<Eigen::Isometry3d>& seeds,
                                                               const PhotometricStart& start, const ClipRange& range) {
  const bool near = start.known_blur > 0.0;
  const double sd = near && parameters.blur != "given" ? start.known_blur : parameters.blur_sd;
  std::vector<SeedFit> fits(seeds.size(), SeedFit(parameters, range));
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    fits[i].state.pose = seeds[i];
    fits[i].state.blur = {sd * sd, 0.0, sd * sd};
    double sides = 0.0;
    movement(camera, placements, seeds[i], seeds[i], sides);
    if (!seeds[i].matrix().allFinite() || !std::isfinite(sides)) fits[i].fail("impossible seed");
  }
  for (int round = near ? 1 : 0; round < kRounds; ++round) {
    const bool first = round == 0;
    const double margin = first ? parameters.margin : kFineMargin;
    const int most = first ? std::min(kSparse, parameters.max_pixels) : parameters.max_pixels;
    const double blur =
        collectAll(parameters, grey, camera, placements, fits, margin, most, parameters.illumination_slope && !first);
    problem.set(camera, placements, samples, blurOf(parameters.blur), parameters.illumination_slope && !first);
    std::vector<Eigen::Isometry3d> before;
    for (SeedFit& fit : fits) {
      before.push_back(fit.state.pose);
      if (first && !fit.failed) fit.approach(problem);
    }
    if (!first) finishAll(fits, near && round == 1, start.brightness);
    bool again = first;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (fits[i].failed) continue;
      double sides = 0.0;
      const double moved = movement(camera, placements, before[i], fits[i].state.pose, sides),
                   now = blurSd(fits[i].state);
      again |= moved > margin || raysPerPixel(now) != raysPerPixel(blur) || now > 1.2 * blur + 0.1;
    }
    if (!again) break;
  }
  for (std::size_t i = 0; i < fits.size(); ++i) conclude(camera, placements, parameters, seeds[i], fits[i]);
  return fits;
}

PhotometricRefiner::PhotometricRefiner(const PhotometricParameters& parameters)
    : parameters_(parameters), workspace_(std::make_unique<Workspace>()) {
  blurOf(parameters.blur);
}

PhotometricRefiner::~PhotometricRefiner() = default;
PhotometricRefiner::PhotometricRefiner(PhotometricRefiner&&) noexcept = default;

PhotometricResult PhotometricRefiner::refine(const cv::Mat& grey, const CameraModel& camera,
                                             const Placements& placements, const Eigen::Isometry3d& initial) {
  return workspace_->fitAll(parameters_, grey, camera, placements, {initial}, {}).front().result;
}

std::vector<PhotometricBranch> PhotometricRefiner::refineBranches(const cv::Mat& grey, const CameraModel& camera,
                                                                  const Placements& placements,
                                                                  const std::vector<Eigen::Isometry3d>& seeds,
                                                                  const PhotometricStart& start) {
  std::vector<PhotometricBranch> branches;
  double sd = std::numeric_limits<double>::infinity();
  for (const SeedFit& fit : workspace_->fitAll(parameters_, grey, camera, placements, seeds, start)) {
    branches.push_back({fit.result, 0.0, 0.0, fit.hopeless});
    if (fit.result.converged) sd = std::min(sd, fit.result.noise_sd);
  }
  double best = std::numeric_limits<double>::infinity(), sum = 0.0;
  for (PhotometricBranch& b : branches) {
    if (!b.result.converged) continue;
    // A cost at its own noise, carried over to the best one's; the same pixels lie behind all of them.
    b.chi_square = 2.0 * b.result.cost / (sd * sd);
    best = std::min(best, b.chi_square);
  }
  for (PhotometricBranch& b : branches) {
    // What the first look would have given up. Not called hopeless: for a small marker the other branch is looked for.
    if (start.brightness && b.result.converged && b.chi_square - best > kClearlyWorse) b.result.converged = false;
    if (b.result.converged) sum += b.weight = std::exp(-0.5 * (b.chi_square - best));
  }
  for (PhotometricBranch& b : branches) b.weight = sum > 0.0 ? b.weight / sum : 0.0;
  return branches;
}

}  // namespace seater_perception
