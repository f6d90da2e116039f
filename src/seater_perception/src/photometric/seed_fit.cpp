#include "photometric/seed_fit.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

constexpr double kQuantisation = 0.29;  // [grey levels] standard deviation of rounding
// Squared lengths of a last step, in standard deviations: what remains after it is a tenth or less of its length.
constexpr double kCoarseDone = 0.5, kFineDone = 2.0;
constexpr int kSettled = 5;                // steps, after which the scale stands still
constexpr double kSettledTolerance = 2.0;  // of kFineDone or kCoarseDone from then on
constexpr int kShrinkings = 8, kShrinkBudget = 5, kLookBudget = 5;
constexpr double kSuspicious = 1.3;  // residuals at edges over those of flat pixels: more is not noise alone
constexpr double kShrink = 0.6, kShrinkTukey = 4.0;
constexpr double kLargestStretch = 1.3;
// The largest scale of the loss: over the noise of flat pixels, and what lens, sharpening and print may add at edges.
constexpr double kLargestScale = 3.0, kModelError = 0.03;  // [noise], [contrast]
constexpr double kSmallestModelError = 0.015;              // [contrast] of images drawn without blur
constexpr double kUnknownNoise = 10.0;  // [grey levels] scale of the first step where no pixel is flat
constexpr double kWildScale = 1e4;      // of the first look, when nothing is known of the residuals
constexpr int kFewPixels = 600;         // no first look for so few
constexpr double kHopeless = 7.5;       // of the loss in the first look, over the noise's variance
constexpr double kSeen = 0.5;           // of the pixels: fewer tell that clipping explains the image
constexpr double kClippedEnd = 0.004;   // of the range: what counts as its end
constexpr double kSameTurn = 0.01;      // [rad] the same
constexpr double kSame = 0.25;          // squared distance of two fits' poses, in standard deviations of the first look

}  // namespace

bool SeedFit::descend(PhotometricProblem& problem, RobustLoss loss, double tukey, double done, double part,
                      bool adapt) {
  problem.limitBlur(state.blur);
  if (!problem.evaluate(state, weighing(loss, tukey), part)) return false;
  ++result.iterations;
  double damping = 0.0;
  int accepted = adapt ? 0 : kSettled;
  while (budget_ > 0) {
    double length = 0.0, stretch = 1.0;
    const bool settled = accepted >= kSettled;
    const LossSums before = problem.loss(weighing(loss, tukey));
    // How much longer than its weighted least squares say a step should be, because weights change along it.
    if (damping == 0.0 && !settled && before.slopes > 0.0)
      stretch = std::clamp(before.weights / before.slopes, 1.0, kLargestStretch);
    const auto next = problem.step(state, damping, stretch, length);
    last_length_ = length / stretch;
    if (next && !scale_guessed_ && length < (settled ? kSettledTolerance : 1.0) * done * scale_ * scale_) {
      state = *next;
      return true;
    }
    --budget_;
    bool better = false;
    if (next) {
      ++result.iterations;
      better = problem.evaluate(*next, weighing(loss, tukey), part) &&
               problem.loss(weighing(loss, tukey)).cost <= before.cost;
    }
    if (better) {
      state = *next;
      damping = damping < 1e-4 ? 0.0 : 0.1 * damping;
      scale_guessed_ = false;
      // With a scale that goes on changing, outliers near its limit could keep the fit from ever ending.
      if (++accepted < kSettled)
        scale_ = std::clamp(problem.spread(0.5), smallestScale(), std::max(smallestScale(), largest_scale_));
    } else {
      damping = std::max(1e-3, 10.0 * damping);
      if (damping > 1e8) return true;  // no step helps: this is the minimum to within rounding
      if (!problem.evaluate(state, weighing(loss, tukey), part)) return false;
    }
  }
  return false;
}

void SeedFit::approach(PhotometricProblem& problem) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  problem.startBrightness(state);
  budget_ = parameters_->max_iterations;
  // What the residuals are like is not known before the first look.
  scale_ = largest_scale_ = kWildScale;
  if (!problem.evaluate(state, weighing(RobustLoss::huber, parameters_->tukey))) return fail("impossible pose");
  scale_ = std::max(smallestScale(), problem.spread(0.5));
  descend(problem, RobustLoss::huber, parameters_->tukey, kCoarseDone, 1.0);
  // Where a part is covered, Huber's minimum lies aside and the residuals at the edges are larger than those of flat
  // pixels. The scale goes down to the latter by and by, so that what is covered is forgotten before what is only
  // displaced.
  const double flat = problem.flatNoise(), noise = std::max(smallestScale(), flat > 0.0 ? flat : problem.spread(0.25));
  for (int i = 0; i < kShrinkings && scale_ > kSuspicious * noise; ++i) {
    scale_ = std::max(noise, kShrink * scale_);
    budget_ = kShrinkBudget;
    descend(problem, RobustLoss::tukey, kShrinkTukey, kCoarseDone, 1.0, false);
  }
}

void SeedFit::start(PhotometricProblem& problem) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  problem.startBrightness(state);
  const double noise = problem.flatNoise();
  scale_ = noise > 0.0 ? kLargestScale * std::max(kQuantisation, noise) : kUnknownNoise;
}

void SeedFit::start(PhotometricProblem& problem, const Brightness& known, const SeedFit* other) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  const double noise = problem.flatNoise();
  scale_ = noise > 0.0 ? kLargestScale * std::max(kQuantisation, noise) : kUnknownNoise;
  scale_guessed_ = true;
  state.brightness = {known};
  if (other) {
    state.brightness = other->state.brightness;
    state.blur = other->state.blur;
    scale_ = other->scale_;
  }
  boundScale(problem);
}

double SeedFit::contrast() const {
  double largest = 0.0;
  for (const Brightness& b : state.brightness) largest = std::max(largest, b.used ? b.gain : 0.0);
  return largest;
}

/// An image without noise is not without model error.
double SeedFit::smallestScale() const {
  return std::max(kQuantisation, kSmallestModelError * contrast());
}

/// A fit that is caught aside sees large residuals at all edges; they must not pass for noise.
void SeedFit::boundScale(const PhotometricProblem& problem) {
  const double noise = problem.flatNoise();
  largest_scale_ = kWildScale;
  if (noise > 0.0) largest_scale_ = kLargestScale * std::max(kQuantisation, noise) + kModelError * contrast();
  scale_ = std::clamp(scale_, smallestScale(), std::max(smallestScale(), largest_scale_));
}

void SeedFit::firstLook(PhotometricProblem& problem) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  boundScale(problem);
  budget_ = kLookBudget;
  const double part = problem.pixels() < kFewPixels ? 1.0 : kPartOfFirstLook;
  descend(problem, RobustLoss::tukey, parameters_->tukey, kCoarseDone, part);
  look_pose_ = state.pose;
  look_cost_ = problem.loss(weighing(RobustLoss::tukey, parameters_->tukey)).cost - 0.5 * last_length_;
}

bool SeedFit::clearlyWorseThan(const SeedFit& other) const {
  const double scale = std::max(other.scale_, scale_);
  return look_cost_ - other.look_cost_ > kHopeless * scale * scale;
}

/// Where two minima lie near to each other the image hardly changes between them: their angle has to be small too.
bool SeedFit::sameAs(const SeedFit& other, const PhotometricProblem& problem) const {
  if (Eigen::AngleAxisd(look_pose_.linear().transpose() * other.look_pose_.linear()).angle() > kSameTurn) return false;
  return problem.distance(look_pose_, other.look_pose_) < kSame * scale_ * scale_;
}

void SeedFit::finish(PhotometricProblem& problem) {
  budget_ = parameters_->max_iterations;
  if (!descend(problem, RobustLoss::tukey, parameters_->tukey, kFineDone, 1.0)) return fail("no convergence");
  judge(problem);
}

/// Noise, score and covariance from the residuals of the last evaluation. Covariance of an M-estimator: Huber, "Robust
/// Statistics", 1981, chapter 7: mean(psi^2) / mean(psi')^2 (J^T J)^-1.
void SeedFit::judge(const PhotometricProblem& problem) {
  const double c2 = parameters_->tukey * parameters_->tukey;
  Weighing own = weighing(RobustLoss::tukey, parameters_->tukey);
  const LossSums sums = problem.loss(own);
  result.pixels = static_cast<int>(sums.all);
  const double freedom = sums.inliers - problem.unknowns();
  blind = sums.all < kSeen * problem.pixels();
  if (!(freedom > kFewestEdgePixels)) return fail("too few inliers");
  result.inlier_share = sums.inliers / sums.all;
  result.rms = std::sqrt(sums.squares / sums.all);
  result.explained = 1.0 - problem.residualSquares() / std::max(1e-9, problem.greySquares());
  // Weighting takes away from the variance of normal noise: E[w r^2] = sigma^2 (1 - 6 / c^2 + 15 / c^4).
  const double floor = kQuantisation * kQuantisation;
  result.noise_sd = std::sqrt(std::max(floor, sums.weighted / freedom / (1.0 - 6.0 / c2 + 15.0 / (c2 * c2))));
  own.scale = result.noise_sd;
  result.cost = problem.loss(own).cost - 0.5 * last_length_;
  result.flat_noise = problem.tellsNoise() ? std::max(kQuantisation, problem.flatNoise()) : 0.0;
  const double end = kClippedEnd * (range_.high - range_.low);
  result.clipped_low = problem.shareBelow(range_.low + end);
  result.clipped_high = problem.shareAbove(range_.high - end);
  result.reduced_chi_square = 1.0;
  if (parameters_->noise_sd > 0.0) {
    const double sd = parameters_->noise_sd, expected = 0.5 * (1.0 - 3.0 / c2 + 5.0 / (c2 * c2));
    own.scale = sd;
    result.reduced_chi_square = problem.loss(own).cost / (expected * (sums.all - problem.unknowns()) * sd * sd);
  }
  const auto inverse = problem.inversePoseInformation();
  if (!inverse) return fail("degenerate image");
  const double mean_slope = std::max(0.1, sums.slopes / sums.inliers);
  const double variance = std::max(floor, sums.psi2 / freedom) / (mean_slope * mean_slope);
  result.covariance = variance * sums.weights / sums.inliers * *inverse;
}

}  // namespace seater_perception
