// Residuals and normal equations of a photometric fit at one state.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "marker/marker_plane.h"
#include "photometric/kernel/photometric_kernel.h"
#include "seater_perception/detection.h"
#include "seater_perception/marker_pattern.h"

namespace seater_perception {

class PhotometricProblem;

/// |r| of a standard normal distribution at its quantiles 0.5 and 0.25: Phi^-1(0.75) and Phi^-1(0.625).
constexpr double kNormalMedian = 0.67449, kNormalQuartile = 0.31864;

/// All unknowns of a photometric fit.
struct PhotometricState {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_optical_object
  SpreadCovariance psf;                ///< of the lens, pixel area not included; may be slightly < 0
  std::vector<Brightness> brightness;  ///< one per placement
};

/// Memory of evaluations, used again by later ones: inner loops allocate nothing. One per thread; it has to outlive all
/// evaluations made with it.
class EvaluationPool {
 public:
  using Block = Eigen::Matrix<double, kColumns, kColumns>;

  struct Buffers {
    PhotometricState state;
    std::vector<Block> blocks;                         ///< per marker, upper triangle of [J r]^T W [J r]
    std::vector<std::vector<float>> residuals, valid;  ///< per marker, and of earlier problems with more of them
    std::vector<int> evaluated;                        ///< how many pixels of each marker
    double slope_damping = 0.0;                        ///< [grey levels^2] added to the information on the slopes
    double rim_damping = 0.0;                          ///< the same on the rim
    double block_squares = 0.0;                        ///< of the flat blocks' residuals
  };
  /// Gives the buffers back.
  struct Return {
    EvaluationPool* pool;
    void operator()(Buffers* buffers) const { pool->free_.emplace_back(buffers); }
  };
  using Lease = std::unique_ptr<Buffers, Return>;

  Lease take();
  /// For sorting; what is in it lasts until the next use.
  std::vector<float>& scratch() { return scratch_; }

 private:
  std::vector<std::unique_ptr<Buffers>> free_;
  std::vector<float> scratch_;
};

/// The least-squares problem linearised at one state (PhotometricProblem::evaluate makes it), which has to live as
/// long.
class Evaluation {
 public:
  Evaluation(const PhotometricProblem& problem, EvaluationPool::Lease data)
      : problem_(&problem), data_(std::move(data)) {}

  /// Loss of the residuals, for any weighing. `part` counts from all pixels.
  LossSums loss(const Weighing& weighing, double part = 1.0) const;
  /// Robust standard deviation of the residuals, from this quantile (0.5 or 0.25) of |residual|; 0 when there are fewer
  /// than 30.
  double spread(double quantile) const;

  struct Step {
    double squared_length = 0.0;            ///< in the metric of the normal equations [grey levels^2]
    std::optional<PhotometricState> state;  ///< nothing: equations singular, or farther than they hold
  };
  /// To the minimum of the damped quadratic model, times `stretch`.
  Step step(double damping, double stretch) const;
  /// Squared distance of two poses in the metric of the normal equations, all else fitted to each [grey levels^2].
  double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;
  /// Inverse of the normal matrix's pose part, everything else marginalised [1/grey levels^2]; nothing when singular.
  std::optional<Matrix6d> inversePoseInformation() const;

  /// Sum of the squared differences of all grey levels from their marker's mean, and of all residuals; each pixel of a
  /// block counts [grey levels^2].
  double greySquares() const;
  double residualSquares() const;

 private:
  using Shared = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9>;
  using SharedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 9, 1>;
  using Own = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5>;

  SpreadCovariance psfAfter(SpreadCovariance psf, const SharedVector& change) const;
  Shared reduced(double damping, SharedVector& right) const;
  Own brightnessInformation(std::size_t m, double damping) const;

  const PhotometricProblem* problem_;
  EvaluationPool::Lease data_;
};

}  // namespace seater_perception
