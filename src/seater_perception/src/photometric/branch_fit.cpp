#include "photometric/branch_fit.h"

#include <algorithm>
#include <cmath>

#include "photometric/shift_evidence.h"
#include "pose/pose.h"

namespace seater_perception {
namespace {

// Where no origin is given, a value was chosen by hand; photometric_test (covariance against the Cramer-Rao bound,
// covered and unblurred prints), camera_effects_test and `perception_accuracy` notice when it is wrong.

constexpr double kQuantisation = 0.29;  // [grey levels] standard deviation of rounding: sqrt(1 / 12)

// When a descent ends. Squared lengths of the last step, in standard deviations of the pose: Gauss-Newton converges so
// fast that what remains after it is a tenth or less of its length.
constexpr double kCoarseDone = 0.5, kFineDone = 2.0;
constexpr int kSettled = 5;                // accepted steps, after which the scale stands still, so that fits end
constexpr double kSettledTolerance = 2.0;  // of kFineDone or kCoarseDone from then on
constexpr double kLargestStretch = 1.3;    // of a step: weights change along it, but not for long
constexpr int kLookBudget = 5;             // steps of a first look

// The scale that shrinks to the noise: 8 times 0.6 are 1/60, from residuals as large as the contrast to noise of a few
// grey levels.
constexpr int kShrinkings = 8, kShrinkBudget = 5;
constexpr double kShrink = 0.6, kShrinkTukey = 4.0;
constexpr double kSuspicious = 1.3;  // residuals at edges over those of flat pixels: more is not noise alone

// The largest scale of the loss: over the noise of flat pixels, and what lens, sharpening and print may add at edges.
constexpr double kLargestScale = 3.0, kModelError = 0.03;  // [noise], [contrast]
constexpr double kSmallestModelError = 0.015;              // [contrast] of images drawn without blur or noise
constexpr double kUnknownNoise = 10.0;                     // [grey levels] first scale where no pixel is flat
constexpr double kWildScale = 1e4;                         // [grey levels] weighs all residuals alike

// First looks. 7.5 of the loss on a quarter of the pixels are a chi-squared of 60 on all of them: exp(-30) by weight.
constexpr double kHopeless = 7.5;   // of the loss, over the noise's variance
constexpr int kFewPixels = 600;     // for fewer, a first look takes all
constexpr double kSameTurn = 0.01;  // [rad] between two fits' poses
constexpr double kSame = 0.25;      // their squared distance in the metric of the first look: half a standard deviation

constexpr double kSeen = 0.5;           // fraction of the pixels: fewer tell that clipping explains the image
constexpr double kClippedEnd = 0.004;   // of the range: its end, one grey level of 255
constexpr double kSmallestSlope = 0.1;  // mean derivative of weight times residual: keeps the covariance finite

}  // namespace

BranchFit::Descent BranchFit::descend(const PhotometricProblem& problem, const Goal& goal) {
  Descent descent;
  problem.limitPsf(state.psf);
  descent.last = problem.evaluate(state, weighing(goal.loss, goal.tukey), goal.part);
  if (!descent.last) return descent;
  ++result.iterations;
  double damping = 0.0;
  int accepted = goal.adapt_scale ? 0 : kSettled;
  while (budget_ > 0) {
    const bool settled = accepted >= kSettled;
    const LossSums before = descent.last->loss(weighing(goal.loss, goal.tukey));
    // How much longer than its weighted least squares say a step should be, because weights change along it.
    double stretch = 1.0;
    if (damping == 0.0 && !settled && before.slopes > 0.0)
      stretch = std::clamp(before.weights / before.slopes, 1.0, kLargestStretch);
    Evaluation::Step next = descent.last->step(damping, stretch);
    descent.last_length = next.squared_length / stretch;
    const double done = (settled ? kSettledTolerance : 1.0) * goal.done * scale_ * scale_;
    if (next.state && !scale_guessed_ && next.squared_length < done) {
      state = std::move(*next.state);
      descent.converged = true;
      return descent;
    }
    --budget_;
    std::optional<Evaluation> trial;
    if (next.state) {
      ++result.iterations;
      trial = problem.evaluate(*next.state, weighing(goal.loss, goal.tukey), goal.part);
    }
    if (trial && trial->loss(weighing(goal.loss, goal.tukey)).cost <= before.cost) {
      state = std::move(*next.state);
      descent.last = std::move(trial);
      damping = damping < 1e-4 ? 0.0 : 0.1 * damping;
      scale_guessed_ = false;
      // With a scale that goes on changing, outliers near its limit could keep the fit from ever ending.
      if (++accepted < kSettled)
        scale_ = std::clamp(scaleOf(*descent.last), smallestScale(), std::max(smallestScale(), largest_scale_));
      continue;
    }
    damping = std::max(1e-3, 10.0 * damping);
    descent.converged = damping > 1e8;  // no step helps: this is the minimum to within rounding
    if (descent.converged) return descent;
    // Again, because the scale may have changed since, and with it the weights.
    descent.last = problem.evaluate(state, weighing(goal.loss, goal.tukey), goal.part);
    if (!descent.last) return descent;
  }
  return descent;
}

void BranchFit::approach(const PhotometricProblem& problem) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  state.brightness = problem.initialBrightness(state);
  budget_ = parameters_->max_iterations;
  // What the residuals are like is not known before the first look.
  scale_ = largest_scale_ = kWildScale;
  const auto first = problem.evaluate(state, weighing(RobustLoss::huber, parameters_->tukey));
  if (!first) return fail("impossible pose");
  scale_ = std::max(smallestScale(), first->spread(0.5));
  const Descent convex = descend(problem, {RobustLoss::huber, parameters_->tukey, kCoarseDone});
  // Where a part is covered, Huber's minimum lies aside and the residuals at the edges are larger than those of flat
  // pixels. The scale goes down to the latter by and by, so that what is covered is forgotten before what is only
  // displaced.
  double noise = problem.flatNoise();
  if (!(noise > 0.0)) noise = (convex.last ? *convex.last : *first).spread(0.25);
  noise = std::max(smallestScale(), noise);
  for (int i = 0; i < kShrinkings && scale_ > kSuspicious * noise; ++i) {
    scale_ = std::max(noise, kShrink * scale_);
    budget_ = kShrinkBudget;
    descend(problem, {RobustLoss::tukey, kShrinkTukey, kCoarseDone, 1.0, false});
  }
}

void BranchFit::start(const PhotometricProblem& problem) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  state.brightness = problem.initialBrightness(state);
  const double noise = problem.flatNoise();
  scale_ = noise > 0.0 ? kLargestScale * std::max(kQuantisation, noise) : kUnknownNoise;
  if (!whole_) return;
  scale_ = std::max(smallestScale(), contrast());  // nothing is left out, even where the fit begins beside the minimum
  scale_guessed_ = true;
}

void BranchFit::start(const PhotometricProblem& problem, const Brightness& known, const BranchFit* other) {
  if (problem.pixels() < kFewestEdgePixels) return fail("too few pixels in the image");
  const double noise = problem.flatNoise();
  scale_ = noise > 0.0 ? kLargestScale * std::max(kQuantisation, noise) : kUnknownNoise;
  scale_guessed_ = true;
  state.brightness = {known};
  if (other) {
    state.brightness = other->state.brightness;
    state.psf = other->state.psf;
    scale_ = other->scale_;
  }
  boundScale(problem);
}

double BranchFit::contrast() const {
  double largest = 0.0;
  for (const Brightness& b : state.brightness) largest = std::max(largest, b.used ? b.gain : 0.0);
  return largest;
}

/// An image without noise is not without model error.
double BranchFit::smallestScale() const {
  return std::max(kQuantisation, kSmallestModelError * contrast());
}

/// [grey levels] Of the median, which does not see what covers a part of a print; of the mean where nothing does.
double BranchFit::scaleOf(const Evaluation& last) const {
  if (!whole_) return last.spread(0.5);
  const LossSums sums = last.loss(weighing(RobustLoss::tukey, parameters_->tukey));
  return std::sqrt(sums.squares / std::max(1.0, sums.all));
}

/// A fit that is caught aside sees large residuals at all edges; they must not pass for noise.
void BranchFit::boundScale(const PhotometricProblem& problem) {
  const double noise = problem.flatNoise();
  largest_scale_ = kWildScale;
  if (noise > 0.0 && !whole_)
    largest_scale_ = kLargestScale * std::max(kQuantisation, noise) + kModelError * contrast();
  scale_ = std::clamp(scale_, smallestScale(), std::max(smallestScale(), largest_scale_));
}

std::optional<Evaluation> BranchFit::firstLook(const PhotometricProblem& problem) {
  if (problem.pixels() < kFewestEdgePixels) {
    fail("too few pixels in the image");
    return std::nullopt;
  }
  boundScale(problem);
  budget_ = kLookBudget;
  const double part = problem.pixels() < kFewPixels ? 1.0 : kPartOfFirstLook;
  Descent look = descend(problem, {RobustLoss::tukey, parameters_->tukey, kCoarseDone, part});
  if (!look.last) {
    fail("impossible pose");
    return std::nullopt;
  }
  look_pose_ = state.pose;
  look_cost_ = look.last->loss(weighing(RobustLoss::tukey, parameters_->tukey)).cost - 0.5 * look.last_length;
  return std::move(look.last);
}

bool BranchFit::clearlyWorseThan(const BranchFit& best) const {
  const double scale = std::max(best.scale_, scale_);
  return look_cost_ - best.look_cost_ > kHopeless * scale * scale;
}

/// Where two minima lie near to each other the image hardly changes between them: their angle has to be small too.
bool BranchFit::sameAs(const BranchFit& best, const Evaluation& look) const {
  if (turnBetween(look_pose_, best.look_pose_) > kSameTurn) return false;
  return look.distance(look_pose_, best.look_pose_) < kSame * scale_ * scale_;
}

void BranchFit::finish(const PhotometricProblem& problem) {
  budget_ = parameters_->max_iterations;
  const Descent end = descend(problem, {RobustLoss::tukey, parameters_->tukey, kFineDone});
  if (!end.converged) return fail("no convergence");
  judge(problem, end);
}

void BranchFit::tellShifts(const PhotometricProblem& problem) {
  const Weighing own = weighing(RobustLoss::tukey, parameters_->tukey);
  result.shifts = shiftEvidence(problem, state, own, result.noise_sd * result.noise_sd);
}

/// Noise, score and covariance from the residuals of the last evaluation. Covariance of an M-estimator: Huber, "Robust
/// Statistics", 1981, chapter 7: mean(psi^2) / mean(psi')^2 (J^T J)^-1.
void BranchFit::judge(const PhotometricProblem& problem, const Descent& end) {
  const Evaluation& last = *end.last;
  const double c2 = parameters_->tukey * parameters_->tukey;
  Weighing own = weighing(RobustLoss::tukey, parameters_->tukey);
  const LossSums sums = last.loss(own);
  result.pixels = static_cast<int>(sums.all);
  const double freedom = sums.inliers - problem.unknowns();
  blind = sums.all < kSeen * problem.pixels();
  if (!(freedom > kFewestEdgePixels)) return fail("too few inliers");
  result.inlier_fraction = sums.inliers / sums.all;
  result.rms = std::sqrt(sums.squares / sums.all);
  result.explained = 1.0 - last.residualSquares() / std::max(1e-9, last.greySquares());
  // Weighting takes away from the variance of normal noise: E[w r^2] = sigma^2 (1 - 6 / c^2 + 15 / c^4).
  const double floor = kQuantisation * kQuantisation;
  result.noise_sd = std::sqrt(std::max(floor, sums.weighted / freedom / (1.0 - 6.0 / c2 + 15.0 / (c2 * c2))));
  own.scale = result.noise_sd;
  result.cost = last.loss(own).cost - 0.5 * end.last_length;
  result.flat_noise = problem.tellsNoise() ? std::max(kQuantisation, problem.flatNoise()) : 0.0;
  const double margin = kClippedEnd * (range_.high - range_.low);
  result.clipped_low = problem.fractionBelow(range_.low + margin);
  result.clipped_high = problem.fractionAbove(range_.high - margin);
  result.reduced_chi_square = 1.0;
  if (parameters_->noise_sd > 0.0) {
    const double sd = parameters_->noise_sd, expected = 0.5 * (1.0 - 3.0 / c2 + 5.0 / (c2 * c2));
    own.scale = sd;
    result.reduced_chi_square = last.loss(own).cost / (expected * (sums.all - problem.unknowns()) * sd * sd);
  }
  const auto inverse = last.inversePoseInformation();
  if (!inverse) return fail("degenerate image");
  const double mean_slope = std::max(kSmallestSlope, sums.slopes / sums.inliers);
  const double variance = std::max(floor, sums.psi2 / freedom) / (mean_slope * mean_slope);
  result.covariance = variance * sums.weights / sums.inliers * *inverse;
}

}  // namespace seater_perception
