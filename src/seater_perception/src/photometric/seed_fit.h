// One seed's way to its minimum.
#pragma once

#include <string>

#include "photometric/photometric_problem.h"

namespace seater_perception {

/// Pixels that a first look takes, of all.
constexpr double kPartOfFirstLook = 0.25;
/// Fewer pixels than these tell no pose.
constexpr int kFewestEdgePixels = 40;

class SeedFit {
 public:
  SeedFit(const PhotometricParameters& parameters, const ClipRange& range) : parameters_(&parameters), range_(range) {}

  PhotometricState state;
  PhotometricResult result;
  bool failed = false;
  bool hopeless = false;  ///< failed because clearly worse than another
  bool blind = false;     ///< failed because clipping is said to hide nearly all pixels

  void fail(const std::string& why) {
    failed = true;
    result.failure = why;
  }

  /// From a rough seed, with few pixels: Huber's convex loss, then Tukey's at a scale that shrinks to the noise.
  void approach(PhotometricProblem& problem);
  /// Instead, from a seed within a tenth of a pixel: what the residuals are like follows from the noise.
  void start(PhotometricProblem& problem);
  /// The same when the brightness is known from elsewhere, or brightness and blur from another seed's finished fit (may
  /// be null) of the same pixels; `finish` may follow at once.
  void start(PhotometricProblem& problem, const Brightness& known, const SeedFit* other);
  /// On the first look's part of the pixels, with Tukey's loss, which forgets outliers. Keeps loss and pose for
  /// clearlyWorseThan and sameAs.
  void firstLook(PhotometricProblem& problem);
  /// On all pixels: pose, noise, covariance, score.
  void finish(PhotometricProblem& problem);

  /// After the first look: whether this fit cannot win any more, or has come to the same minimum.
  bool clearlyWorseThan(const SeedFit& other) const;
  bool sameAs(const SeedFit& other, const PhotometricProblem& problem) const;

 private:
  Weighing weighing(RobustLoss loss, double tukey) const { return {scale_, loss, tukey, range_}; }
  bool descend(PhotometricProblem& problem, RobustLoss loss, double tukey, double done, double part, bool adapt = true);
  double contrast() const;
  double smallestScale() const;
  void boundScale(const PhotometricProblem& problem);
  void judge(const PhotometricProblem& problem);

  const PhotometricParameters* parameters_;
  ClipRange range_;
  double scale_ = 1e4;  // noise that the loss is measured with [grey levels]
  double largest_scale_ = 1e4;
  bool scale_guessed_ = false;  // nothing has been seen yet that tells it
  int budget_ = 0;
  double last_length_ = 0.0;  // of the step that followed the last evaluation [grey levels^2]
  double look_cost_ = 0.0;    // of the first look [grey levels^2]
  Eigen::Isometry3d look_pose_ = Eigen::Isometry3d::Identity();
};

}  // namespace seater_perception
