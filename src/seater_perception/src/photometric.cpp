#include "seater_perception/photometric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "seater_perception/dock_layout.h"
#include "seater_perception/errors.h"
#include "seater_perception/photometric_fit.h"

namespace seater_perception {
namespace {

constexpr double kQuantisation = 0.29;  // [grey levels] standard deviation of rounding
constexpr double kFineMargin = 0.3;     // [px] the approach ends nearer than this
constexpr int kFewestEdgePixels = 40;
constexpr int kRounds = 4;  // of collecting pixels: the approach, then again while a marker leaves its band
constexpr double kCoarseDone = 0.1, kFineDone = 1e-2;  // squared length of a last step in standard deviations
constexpr int kSettled = 5;                            // steps, after which the scale stands still
constexpr double kSettledTolerance = 5.0;              // of kFineDone or kCoarseDone from then on
constexpr int kShrinkings = 8, kShrinkBudget = 5;
constexpr double kSuspicious = 1.3;  // residuals at edges over those of flat pixels: more is not noise alone
constexpr double kShrink = 0.6, kShrinkTukey = 4.0;
constexpr double kLargestScale = 3.0;  // over the noise of flat pixels: what a wrong form of blur may add at edges
constexpr double kWildScale = 1e4;     // of the first look, when nothing is known of the residuals

using Blur = PhotometricProblem::Blur;

Blur blurOf(const std::string& name) {
  if (name == "given") return Blur::given;
  if (name == "estimated") return Blur::round;
  if (name == "directed") return Blur::directed;
  throw ConfigurationError("photometric/blur: is '" + name + "', must be given, estimated or directed");
}

/// One seed on its way.
struct Fit {
  PhotometricState state;
  PhotometricResult result;
  double scale = kWildScale;
  double largest_scale = kWildScale;  // of the loss in the end; known after the approach
  int budget = 0;
  bool failed = false;

  void fail(const std::string& why) {
    failed = true;
    result.failure = why;
  }
};

/// Levenberg-Marquardt; true when the last step was shorter than `done`.
bool descend(PhotometricProblem& problem, Fit& fit, RobustLoss loss, double tukey, double done, bool adapt = true) {
  const int stride = 1;
  if (!problem.evaluate(fit.state, fit.scale, loss, tukey, stride)) return false;
  ++fit.result.iterations;
  double damping = 0.0;
  int accepted = adapt ? 0 : kSettled;
  while (fit.budget > 0) {
    double length = 0.0;
    const bool settled = accepted >= kSettled;
    const double stretch = damping > 0.0 || settled ? 1.0 : problem.stretch(fit.scale, loss, tukey);
    const auto next = problem.step(fit.state, damping, stretch, length);
    if (next && length < (settled ? kSettledTolerance : 1.0) * done * fit.scale * fit.scale) {
      fit.state = *next;
      return true;
    }
    --fit.budget;
    const double before = problem.cost(fit.scale, loss, tukey);
    bool better = false;
    if (next) {
      ++fit.result.iterations;
      better =
          problem.evaluate(*next, fit.scale, loss, tukey, stride) && problem.cost(fit.scale, loss, tukey) <= before;
    }
    if (better) {
      fit.state = *next;
      damping = damping < 1e-4 ? 0.0 : 0.1 * damping;
      // With a scale that goes on changing, outliers near its limit could keep the fit from ever ending.
      if (++accepted < kSettled) fit.scale = std::clamp(problem.spread(0.5), kQuantisation, fit.largest_scale);
    } else {
      damping = std::max(1e-3, 10.0 * damping);
      if (damping > 1e8) return true;  // no step helps: this is the minimum to within rounding
      if (!problem.evaluate(fit.state, fit.scale, loss, tukey, stride)) return false;
    }
  }
  return false;
}

/// Comes near, with few pixels and Huber's convex loss.
void approach(PhotometricProblem& problem, const PhotometricParameters& parameters, Fit& fit) {
  if (problem.edgePixels() < kFewestEdgePixels) return fit.fail("too few pixels in the picture");
  problem.startBrightness(fit.state);
  fit.budget = parameters.max_iterations;
  // What the residuals are like is not known before the first look.
  if (!problem.evaluate(fit.state, kWildScale, RobustLoss::huber, parameters.tukey, 1))
    return fit.fail("impossible pose");
  fit.scale = std::max(kQuantisation, problem.spread(0.5));
  descend(problem, fit, RobustLoss::huber, parameters.tukey, kCoarseDone);
  // Where a part is covered, Huber's minimum lies aside and the residuals at the edges are larger than those of flat
  // pixels. The scale goes down to the latter by and by, so that what is covered is forgotten before what is only
  // displaced.
  const double flat = problem.flatNoise(), noise = std::max(kQuantisation, flat > 0.0 ? flat : problem.spread(0.25));
  for (int i = 0; i < kShrinkings && fit.scale > kSuspicious * noise; ++i) {
    fit.scale = std::max(noise, kShrink * fit.scale);
    fit.budget = kShrinkBudget;
    descend(problem, fit, RobustLoss::tukey, kShrinkTukey, kCoarseDone, false);
  }
  fit.budget = parameters.max_iterations;
}

/// Instead of the approach, from a seed within some hundredths of a pixel.
void start(PhotometricProblem& problem, const PhotometricParameters& parameters, Fit& fit) {
  if (problem.edgePixels() < kFewestEdgePixels) return fit.fail("too few pixels in the picture");
  problem.startBrightness(fit.state);
  fit.budget = parameters.max_iterations;
  if (!problem.evaluate(fit.state, kWildScale, RobustLoss::huber, parameters.tukey, 1))
    return fit.fail("impossible pose");
  fit.scale = std::max(kQuantisation, problem.spread(0.5));
}

/// Ends there, with all pixels and Tukey's loss, which forgets outliers.
void finish(PhotometricProblem& problem, const PhotometricParameters& parameters, Fit& fit) {
  if (problem.edgePixels() < kFewestEdgePixels) return fit.fail("too few pixels in the picture");
  // A fit that is caught aside sees large residuals at all edges; they must not pass for noise.
  const double noise = problem.flatNoise();
  if (noise > 0.0) fit.largest_scale = kLargestScale * std::max(kQuantisation, noise);
  fit.scale = std::min(fit.scale, fit.largest_scale);
  if (!descend(problem, fit, RobustLoss::tukey, parameters.tukey, kFineDone)) fit.fail("no convergence");
}

/// Noise, score and covariance from the residuals of the last evaluation. Covariance of an M-estimator: Huber, "Robust
/// Statistics", 1981, chapter 7: mean(psi^2) / mean(psi')^2 (J^T J)^-1.
void judge(const PhotometricProblem& problem, const PhotometricParameters& parameters, Fit& fit) {
  const double c = parameters.tukey, c2 = c * c;
  double inliers = 0.0, all = 0.0, squares = 0.0, weighted = 0.0, psi2 = 0.0, slope = 0.0, weights = 0.0;
  for (const double r : problem.residuals()) {
    if (std::isnan(r)) continue;
    all += 1.0;
    squares += r * r;
    const double u2 = r * r / (c2 * fit.scale * fit.scale);
    if (u2 >= 1.0) continue;
    const double w = (1.0 - u2) * (1.0 - u2);
    inliers += 1.0;
    weights += w;
    weighted += w * r * r;
    psi2 += w * w * r * r;
    slope += (1.0 - u2) * (1.0 - 5.0 * u2);
  }
  PhotometricResult& result = fit.result;
  result.pixels = static_cast<int>(all);
  const double freedom = inliers - problem.unknowns();
  if (!(freedom > kFewestEdgePixels)) return fit.fail("too few inliers");
  result.inlier_share = inliers / all;
  result.rms = std::sqrt(squares / all);
  result.explained = 1.0 - squares / std::max(1e-9, problem.greySquares());
  // Weighting takes away from the variance of normal noise: E[w r^2] = sigma^2 (1 - 6 / c^2 + 15 / c^4).
  const double floor = kQuantisation * kQuantisation;
  result.noise_sd = std::sqrt(std::max(floor, weighted / freedom / (1.0 - 6.0 / c2 + 15.0 / (c2 * c2))));
  result.cost = problem.cost(result.noise_sd, RobustLoss::tukey, c);
  result.reduced_chi_square = 1.0;
  if (parameters.noise_sd > 0.0) {
    const double sd = parameters.noise_sd, expected = 0.5 * (1.0 - 3.0 / c2 + 5.0 / (c2 * c2));
    result.reduced_chi_square =
        problem.cost(sd, RobustLoss::tukey, c) / (expected * (all - problem.unknowns()) * sd * sd);
  }
  const auto inverse = problem.inversePoseInformation();
  if (!inverse) return fit.fail("degenerate picture");
  const double mean_slope = std::max(0.1, slope / inliers);
  const double variance = std::max(floor, psi2 / freedom) / (mean_slope * mean_slope);
  result.covariance = variance * weights / inliers * *inverse;
}

/// Largest movement of a marker's corner in the picture [px], and in sides of the marker; infinite when behind the
/// camera.
double movement(const CameraModel& camera, const std::vector<PatternPlacement>& placements, const Eigen::Isometry3d& a,
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
void conclude(const CameraModel& camera, const std::vector<PatternPlacement>& placements,
              const PhotometricParameters& parameters, const Eigen::Isometry3d& seed, Fit& fit) {
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
  result.blur_elongation = std::sqrt((mean + half + area) / (mean - half + area));
  const bool finite = fit.state.pose.matrix().allFinite() && result.covariance.allFinite() &&
                      std::isfinite(result.noise_sd + result.blur_sd + result.blur_elongation);
  if (!fit.failed && !finite) fit.fail("not finite");
  if (fit.failed) {
    const PhotometricResult nothing;
    const std::string why = result.failure;
    const int iterations = result.iterations;
    result = nothing;
    result.failure = why;
    result.iterations = iterations;
    result.pose = seed;
    result.brightness.assign(placements.size(), {});
    return;
  }
  result.converged = true;
  result.pose = fit.state.pose;
  result.pose.linear() = Eigen::Quaterniond(fit.state.pose.linear()).normalized().toRotationMatrix();
  result.brightness = fit.state.brightness;
}

void requirePicture(const cv::Mat& grey, const CameraModel& camera) {
  if (grey.type() != CV_8UC1 && grey.type() != CV_16UC1) throw PictureError("picture: must be CV_8UC1 or CV_16UC1");
  if (grey.cols != camera.width() || grey.rows != camera.height()) {
    throw PictureError("picture: is " + std::to_string(grey.cols) + " x " + std::to_string(grey.rows) + ", must be " +
                       std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
  }
}

double blurSd(const PhotometricState& state) {
  return std::sqrt(std::max(0.0, 0.5 * (state.blur.uu + state.blur.vv)));
}

/// Pixels of all markers, the same for all fits; returns the widest blur of the fits, for which they are meant [px].
double collectAll(const PhotometricParameters& parameters, const cv::Mat& grey, const CameraModel& camera,
                  const std::vector<PatternPlacement>& placements, const std::vector<Fit>& fits, double margin,
                  bool sparse, std::vector<MarkerSamples>& samples) {
  double blur = 0.0;
  for (const Fit& fit : fits) blur = std::max(blur, fit.failed ? 0.0 : blurSd(fit.state));
  for (std::size_t m = 0; m < placements.size(); ++m) {
    std::vector<Eigen::Isometry3d> poses;
    for (const Fit& fit : fits) {
      if (!fit.failed) poses.push_back(fit.state.pose * placements[m].T_object_marker);
    }
    samples[m] = MarkerSamples();
    if (!poses.empty())
      samples[m] = collectSamples(grey, camera, placements[m], poses, blur, margin, sparse, parameters);
  }
  return blur;
}

/// All seeds on the same pixels.
std::vector<Fit> refineAllSeeds(const PhotometricParameters& parameters, const cv::Mat& grey, const CameraModel& camera,
                                const std::vector<PatternPlacement>& placements,
                                const std::vector<Eigen::Isometry3d>& seeds, bool near) {
  requirePicture(grey, camera);
  const double sd = parameters.blur_sd;
  std::vector<Fit> fits(seeds.size());
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    fits[i].state.pose = seeds[i];
    fits[i].state.blur = {sd * sd, 0.0, sd * sd};
    double sides = 0.0;
    movement(camera, placements, seeds[i], seeds[i], sides);
    if (!seeds[i].matrix().allFinite() || !std::isfinite(sides)) fits[i].fail("impossible seed");
  }
  const double limit = parameters.saturation > 0.0 ? parameters.saturation : grey.depth() == CV_16U ? 65535.0 : 255.0;
  std::vector<MarkerSamples> samples(placements.size());
  for (int round = near ? 1 : 0; round < kRounds; ++round) {
    const bool first = round == 0;
    const bool begin = near && round == 1;  // without an approach
    const double margin = first ? parameters.margin : kFineMargin;
    const double blur = collectAll(parameters, grey, camera, placements, fits, margin, first, samples);
    PhotometricProblem problem(placements, samples, blurOf(parameters.blur), parameters.illumination_slope && !first,
                               {0.0, limit});
    bool again = first;
    for (Fit& fit : fits) {
      if (fit.failed) continue;
      const Eigen::Isometry3d before = fit.state.pose;
      if (begin) start(problem, parameters, fit);
      if (!fit.failed) first ? approach(problem, parameters, fit) : finish(problem, parameters, fit);
      if (!first && !fit.failed) judge(problem, parameters, fit);
      double sides = 0.0;
      const double moved = movement(camera, placements, before, fit.state.pose, sides), now = blurSd(fit.state);
      again |= !fit.failed && (moved > margin || raysPerPixel(now) != raysPerPixel(blur) || now > 1.2 * blur + 0.1);
    }
    if (!again) break;
  }
  for (std::size_t i = 0; i < fits.size(); ++i) conclude(camera, placements, parameters, seeds[i], fits[i]);
  return fits;
}

}  // namespace

PhotometricRefiner::PhotometricRefiner(const PhotometricParameters& parameters) : parameters_(parameters) {
  blurOf(parameters.blur);
}

PhotometricResult PhotometricRefiner::refine(const cv::Mat& grey, const CameraModel& camera,
                                             const std::vector<PatternPlacement>& placements,
                                             const Eigen::Isometry3d& initial) const {
  return refineAllSeeds(parameters_, grey, camera, placements, {initial}, false).front().result;
}

std::vector<PhotometricBranch> refineBranches(const PhotometricRefiner& refiner, const cv::Mat& grey,
                                              const CameraModel& camera,
                                              const std::vector<PatternPlacement>& placements,
                                              const std::vector<Eigen::Isometry3d>& seeds, bool near) {
  std::vector<PhotometricBranch> branches;
  double sd = std::numeric_limits<double>::infinity();
  for (const Fit& fit : refineAllSeeds(refiner.parameters(), grey, camera, placements, seeds, near)) {
    branches.push_back({fit.result, 0.0, 0.0});
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
    if (b.result.converged) sum += b.weight = std::exp(-0.5 * (b.chi_square - best));
  }
  for (PhotometricBranch& b : branches) b.weight = sum > 0.0 ? b.weight / sum : 0.0;
  return branches;
}

}  // namespace seater_perception
