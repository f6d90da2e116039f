#pragma once

#include <optional>
#include <vector>

#include "stage/marker_stage.h"

namespace seater_perception {

/// One marker's photometric fits, and how far the image deviates from their model.
class MarkerFits {
 public:
  /// `tracked`: as of refineMarker. Both arguments have to outlive it.
  MarkerFits(const PhotometricContext& context, const MarkerEstimate& marker, bool tracked);

  /// From all poses that the corners leave open, and where only one minimum has been seen, from the other branch too.
  /// `psf_sd` as of PhotometricStart.
  std::vector<PoseHypothesis> fit(PhotometricRefiner& by, double psf_sd);

  /// From all poses that the corners leave open, all residuals counted; nothing where something may cover the print.
  std::vector<PoseHypothesis> fitWhole(PhotometricRefiner& by);

  /// Whether the edges of a whole print are already worse than that (residuals about their own steps over the noise
  /// round the marker), or could not be fitted.
  bool unlikeModel(double misfit);

  int cells() const { return cells_; }
  /// Of the best one of the last fits: residuals at edges over the noise of flat pixels, and the standard
  /// deviation of the lens' point spread function [px].
  double misfit() const { return misfit_; }
  double psfSd() const { return psf_sd_; }
  /// [grey levels] rms at edges, of the same.
  double residual() const { return residual_; }
  /// Of the same, as of PhotometricResult; 0: none has converged.
  double explained() const { return explained_; }
  /// [px] standard deviation of a corner by what the residuals at edges are more than noise; 0: they are noise.
  double modelSigma() const { return model_sigma_; }
  /// Of the same: white is cut off, which grows into black.
  bool whiteCutOff() const { return white_cut_off_; }
  /// What the same has left over of shifts of parts of the print.
  const ShiftEvidence& shifts() const { return shifts_; }
  /// What chi-squared has to be divided by to be believed.
  double doubt() const;

 private:
  std::vector<PoseHypothesis> fitFrom(PhotometricRefiner& by, const std::vector<Eigen::Isometry3d>& initial,
                                      const PhotometricStart& start);
  void compareWithNoise(const PhotometricResult& result);
  double smallestExplained() const;
  double noiseRound();
  double noiseBeside(const PhotometricResult& result);

  const PhotometricContext& context_;
  const MarkerEstimate& marker_;
  const std::vector<PatternPlacement> placement_;
  const int cells_;
  std::optional<Brightness> brightness_;
  std::vector<PhotometricBranch> branches_;  // of the last fits
  double residual_ = 0.0, misfit_ = 0.0, psf_sd_ = 0.0, model_sigma_ = 0.0, explained_ = 0.0;
  ShiftEvidence shifts_;
  bool white_cut_off_ = false;
  double beside_ = 0.0;  // noise round the marker, once it is known
};

}  // namespace seater_perception
