// One initial pose's way to its minimum.
#pragma once

#include <optional>
#include <string>

#include "photometric/photometric_problem.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// Fraction of the pixels that a first look takes: one of the buckets they are dealt into (photometric_samples.cpp).
constexpr double kPartOfFirstLook = 0.25;
/// Fewer pixels than these tell no pose: about three for each of up to 14 unknowns; chosen by hand.
constexpr int kFewestEdgePixels = 40;

class BranchFit {
 public:
  /// `whole` as of PhotometricStart.
  BranchFit(const PhotometricParameters& parameters, const ClipRange& range, bool whole)
      : parameters_(&parameters), range_(range), whole_(whole) {}

  PhotometricState state;
  PhotometricResult result;
  bool failed = false;
  bool hopeless = false;  ///< failed because clearly worse than another
  bool blind = false;     ///< failed because clipping is said to hide nearly all pixels

  void fail(const std::string& why) {
    failed = true;
    result.failure = why;
  }

  /// From a rough initial pose, with few pixels: Huber's convex loss, then Tukey's at a scale that shrinks to the
  /// noise.
  void approach(const PhotometricProblem& problem);
  /// Instead, from a pose within a tenth of a pixel: what the residuals are like follows from the noise.
  void start(const PhotometricProblem& problem);
  /// The same when the brightness is known from elsewhere, or brightness and point spread function from another's
  /// finished fit (may be null) of the same pixels; `finish` may follow at once.
  void start(const PhotometricProblem& problem, const Brightness& known, const BranchFit* other);

  /// On the first look's part of the pixels, with Tukey's loss, which forgets outliers. Keeps cost and pose for the
  /// comparisons below. Returns the last evaluation; nothing when the look has failed.
  std::optional<Evaluation> firstLook(const PhotometricProblem& problem);
  /// After first looks, that of `best` finished since: whether this fit cannot win any more.
  bool clearlyWorseThan(const BranchFit& best) const;
  /// Whether both first looks came to the same minimum. `look`: as this one's firstLook returned it.
  bool sameAs(const BranchFit& best, const Evaluation& look) const;
  /// On all pixels: pose, noise, covariance, score.
  void finish(const PhotometricProblem& problem);
  /// After that, of one print: what is left over of shifts.
  void tellShifts(const PhotometricProblem& problem);

 private:
  struct Goal {
    RobustLoss loss;
    double tukey;  ///< [scales] limit of Tukey's loss
    double done;   ///< squared length of the last step [scales^2]
    double part = 1.0;
    bool adapt_scale = true;  ///< the scale follows the residuals for the first steps
  };
  struct Descent {
    bool converged = false;
    std::optional<Evaluation> last;  ///< at the last state evaluated; nothing when the first one is impossible
    double last_length = 0.0;        ///< squared length of the step that followed it [grey levels^2]
  };
  Weighing weighing(RobustLoss loss, double tukey) const { return {scale_, loss, tukey, range_}; }
  Descent descend(const PhotometricProblem& problem, const Goal& goal);
  double contrast() const;
  double smallestScale() const;
  void boundScale(const PhotometricProblem& problem);
  double scaleOf(const Evaluation& last) const;
  void judge(const PhotometricProblem& problem, const Descent& end);

  const PhotometricParameters* parameters_;
  ClipRange range_;
  bool whole_;
  double scale_ = 1e4;  // noise that the loss is measured with [grey levels]
  double largest_scale_ = 1e4;
  bool scale_guessed_ = false;  // nothing has been seen yet that tells it
  int budget_ = 0;              // steps left
  double look_cost_ = 0.0;      // of the first look [grey levels^2]
  Eigen::Isometry3d look_pose_ = Eigen::Isometry3d::Identity();
};

}  // namespace seater_perception
