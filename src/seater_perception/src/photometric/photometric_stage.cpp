#include "photometric/photometric_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "photometric/initial_poses.h"
#include "seater_perception/dock_layout.h"

namespace seater_perception {
namespace {

// Chosen by hand between what true markers and what other dark squares show. `perception_accuracy` counts missed
// markers and `perception_range` false ones; detection_test, plain_markers_test and tracker_cases_test notice too.

// Part of the image's variance that the pattern has to explain: a small marker has to be proved by it, a large one
// has been read bit by bit and may be partly covered.
constexpr double kExplainedSmall = 0.9, kExplainedLarge = 0.85;
constexpr double kBeyondScale = 0.15;  // [ranges of grey levels] how far black and white may lie beyond the sensor's
constexpr double kClipped = 0.05;     // fraction of the pixels at an end, from which on white or black may lie anywhere
constexpr double kLargestPsf = 0.95;  // [cells] standard deviation; wider, cells cannot be told apart
// Residuals at edges over those of flat pixels, and distance from the fitted edges' corners over its standard
// deviation: from here on, the print is not what the model says (docs/explanation/perception.md).
constexpr double kMisfit = 1.8, kContradiction = 1.0;
constexpr double kCoarseCorners = 0.25;   // [cells] error of corners that no edge confirms
constexpr double kBlurredCorners = 0.25;  // [standard deviations of the PSF] the same of blurred edges
// [px] of a corner: what taking away a shadow's edge leaves; by the normalised errors of `perception_shadows`.
constexpr double kShadowSigma = 0.06;
// [px] rms, between a marker's own corners and those of the joint pose: six times corner_sigma (0.05); chosen by hand.
constexpr double kDisplaced = 0.3;

/// Grey levels that the sensor could have seen, and a point spread function that leaves cells distinct.
bool plausible(const PhotometricResult& result, double side, int cells, double full_scale) {
  // Where the image is clipped, the sensor does not know how dark or light it would have been.
  const auto beyond = [full_scale](double clipped) { return (clipped > kClipped ? 1.0 : kBeyondScale) * full_scale; };
  const double least = -beyond(result.clipped_low), most = full_scale + beyond(result.clipped_high);
  for (const Brightness& b : result.brightness) {
    if (b.used && (b.offset < least || b.offset + b.gain > most)) return false;
  }
  return result.psf_sd < kLargestPsf * side / cells;
}

bool explains(const PhotometricResult& result, double smallest) {
  return result.converged && result.explained > smallest;
}

/// Distinct results as hypotheses; chi_squared counts from the best one.
std::vector<PoseHypothesis> distinct(const std::vector<PhotometricBranch>& branches, double smallest) {
  std::vector<PoseHypothesis> hypotheses;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& b : branches) best = explains(b.result, smallest) ? std::min(best, b.chi_square) : best;
  for (const auto& b : branches) {
    if (!explains(b.result, smallest)) continue;
    const auto same = [&](const PoseHypothesis& h) {
      const double turn = Eigen::AngleAxisd(h.pose.linear().transpose() * b.result.pose.linear()).angle();
      return turn < 0.5 * std::sqrt(b.result.covariance.bottomRightCorner<3, 3>().trace());
    };
    if (std::any_of(hypotheses.begin(), hypotheses.end(), same)) continue;
    PoseHypothesis h;
    h.pose = b.result.pose;
    h.covariance = b.result.covariance;
    h.chi_squared = b.chi_square - best;
    hypotheses.push_back(h);
  }
  return hypotheses;
}

/// Adds what camera and print may deviate from the model: as if corners were uncertain by it.
void addModelError(const CameraModel& camera, Correspondences corners, double sigma,
                   std::vector<PoseHypothesis>& hypotheses) {
  if (!(sigma > 0.0)) return;
  for (double& s : corners.sigma) s = sigma;
  for (auto& h : hypotheses) {
    if (const auto covariance = poseCovariance(camera, corners, h.pose)) h.covariance += *covariance;
  }
}

void weighByPrior(std::vector<PoseHypothesis>& hypotheses, const PosePrior& prior, double tilt_sigma) {
  std::vector<double> cost;
  for (const auto& h : hypotheses) cost.push_back(h.chi_squared + tiltCost(h, prior, tilt_sigma));
  const double best = *std::min_element(cost.begin(), cost.end());
  double sum = 0.0;
  for (std::size_t i = 0; i < cost.size(); ++i) sum += hypotheses[i].weight = std::exp(-0.5 * (cost[i] - best));
  for (auto& h : hypotheses) h.weight /= sum;
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.weight > b.weight; });
}

/// Corners as the pose has them, with their own standard deviation.
void placeCorners(const CameraModel& camera, const PoseHypothesis& hypothesis, double smallest_sigma,
                  MarkerEstimate& marker) {
  std::array<Eigen::Vector2d, 4> corners;
  double variance = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d arm = hypothesis.pose.linear() * markerCorners(marker.size)[i];
    const Eigen::Vector3d point = arm + hypothesis.pose.translation();
    const auto pixel = camera.project(point);
    if (!pixel) return;
    corners[i] = *pixel;
    const Eigen::Matrix<double, 2, 6> J = pixelByPose(camera, arm, point);
    variance += (J * hypothesis.covariance * J.transpose()).trace() / 8.0;
  }
  marker.image.corners = corners;
  marker.image.corner_sigma = std::max(smallest_sigma, std::sqrt(variance));
}

/// Largest rms distance between the corners of a marker as it was seen and as the dock's pose has them [px]. `all`
/// gathers the corners of the markers that are part of it.
double largestDistance(const CameraModel& camera, const DockLayout& layout, const std::vector<MarkerEstimate>& markers,
                       const std::vector<int>& ids, const Eigen::Isometry3d& T_optical_dock, Correspondences& all) {
  double largest = 0.0;
  all = Correspondences();
  for (const MarkerEstimate& m : markers) {
    const auto place = layout.markers.find(m.image.id);
    if (place == layout.markers.end() || !std::count(ids.begin(), ids.end(), m.image.id)) continue;
    Correspondences seen;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d corner = place->second.T_dock_marker() * markerCorners(m.size)[i];
      if (!seen.add(corner, m.image.corners[i], 1.0, camera)) return std::numeric_limits<double>::infinity();
    }
    largest = std::max(largest, reprojectionError(camera, seen, T_optical_dock));
    all.append(seen);
  }
  return largest;
}

/// One marker's fits.
class MarkerFits {
 public:
  MarkerFits(const PhotometricContext& context, const MarkerEstimate& marker, bool tracked)
      : context_(context),
        marker_(marker),
        placement_{{context.patterns.of(marker.image.id), marker.size, Eigen::Isometry3d::Identity()}},
        cells_(placement_.front().pattern.cells()) {
    if (tracked) brightness_ = Brightness{true, marker.image.dark, marker.image.contrast, 0.0, 0.0, 0.0};
  }

  /// From all poses that the corners leave open, and where only one minimum has been seen, from the other branch too.
  /// `psf_sd` as of PhotometricStart.
  std::vector<PoseHypothesis> fit(PhotometricRefiner& by, double psf_sd) {
    auto found = fitFrom(by, openPoses(marker_), {psf_sd, brightness_});
    if (!otherBranchOpen(marker_, branches_, found)) return found;
    const double near = psf_sd > 0.0 ? psf_sd : by.parameters().psf_sd;
    const auto both = fitFrom(by, steepPoses(found.front().pose), {near, std::nullopt});
    return both.empty() ? found : both;
  }

  int cells() const { return cells_; }
  /// Of the best one of the last fits: residuals at edges over those of flat pixels (0: not known), and the standard
  /// deviation of the lens' point spread function [px].
  double misfit() const { return misfit_; }
  double psfSd() const { return psf_sd_; }

 private:
  std::vector<PoseHypothesis> fitFrom(PhotometricRefiner& by, const std::vector<Eigen::Isometry3d>& initial,
                                      const PhotometricStart& start) {
    branches_ = by.refineBranches(context_.grey, context_.camera, placement_, initial, start);
    const double side = marker_.image.side(), full_scale = context_.grey.depth() == CV_16U ? 65535.0 : 255.0;
    double best = std::numeric_limits<double>::infinity();
    for (auto& b : branches_) {
      b.result.converged = b.result.converged && plausible(b.result, side, cells_, full_scale);
      if (!b.result.converged || b.chi_square >= best) continue;
      best = b.chi_square;
      misfit_ = b.result.flat_noise > 0.0 ? b.result.noise_sd / b.result.flat_noise : 0.0;
      psf_sd_ = b.result.psf_sd;
    }
    return distinct(branches_, side < kLargeMarker ? kExplainedSmall : kExplainedLarge);
  }

  const PhotometricContext& context_;
  const MarkerEstimate& marker_;
  const std::vector<PatternPlacement> placement_;
  const int cells_;
  std::optional<Brightness> brightness_;
  std::vector<PhotometricBranch> branches_;  // of the last fits
  double misfit_ = 0.0, psf_sd_ = 0.0;
};

/// Leaves out what says nothing and what the corners contradict. False when the corners cannot be undistorted.
bool compareWithCorners(const PhotometricContext& context, const MarkerEstimate& marker, int cells,
                        std::vector<PoseHypothesis>& hypotheses) {
  Correspondences seen;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!seen.add(markerCorners(marker.size)[i], marker.image.corners[i], 1.0, context.camera)) return false;
  }
  const double sigma = std::max(context.pose.model_sigma, marker.image.shadow ? kShadowSigma : 0.0);
  addModelError(context.camera, seen, sigma, hypotheses);
  for (auto& h : hypotheses) h.error = reprojectionError(context.camera, seen, h.pose);
  // Corners that no edge confirms may be some tenths of a cell off, those of blurred edges a part of the PSF.
  const double side = marker.image.side();
  const double coarse =
      marker.image.edges_fitted ? kBlurredCorners * marker.image.psf_sd : kCoarseCorners * side / cells;
  const double limit = largestError(side, context.pose) + coarse;
  const auto unbelievable = [&](const PoseHypothesis& h) { return !meaningful(h) || h.error > limit; };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), unbelievable), hypotheses.end());
  return true;
}

}  // namespace

const MarkerPattern& PatternBook::of(int id) {
  const auto known = patterns_.find(id);
  if (known != patterns_.end()) return known->second;
  return patterns_.emplace(id, family_.pattern(id)).first->second;
}

RefinedMarker refineMarker(const PhotometricContext& context, const PosePrior& prior, const MarkerEstimate& marker,
                           bool tracked) {
  MarkerFits fits(context, marker, tracked);
  const double psf_sd = marker.image.edges_fitted || tracked ? marker.image.psf_sd : 0.0;
  auto hypotheses = fits.fit(context.refiner, psf_sd);
  if (tracked && (hypotheses.empty() || fits.misfit() > kMisfit)) return {MarkerOutcome::doubtful, marker};
  if (hypotheses.empty() && psf_sd > 0.0) hypotheses = fits.fit(context.refiner, 0.0);
  if (hypotheses.empty() && marker.image.side() > kLargeMarker) {
    // The quiet zone may be darker than the print's white (cut close and pasted on a wall): the print alone, then.
    PhotometricParameters print_only = context.refiner.parameters();
    print_only.quiet_zone = 0.0;
    PhotometricRefiner refiner(print_only);
    hypotheses = fits.fit(refiner, psf_sd);
  }
  if (hypotheses.empty() || !compareWithCorners(context, marker, fits.cells(), hypotheses) || hypotheses.empty())
    return {MarkerOutcome::refused, marker};
  weighByPrior(hypotheses, prior, context.pose.tilt_sigma);
  // A print that is bent or has grown cells: where the model does not hold, the outer edges are what its size means.
  const double contradiction = kContradiction * context.pose.corner_sigma;
  if (marker.image.edges_fitted && fits.misfit() > kMisfit && hypotheses.front().error > contradiction)
    return {MarkerOutcome::corners_kept, marker};
  RefinedMarker refined{MarkerOutcome::refined, marker};
  refined.marker.hypotheses = hypotheses;
  refined.marker.image.psf_sd = fits.psfSd();
  placeCorners(context.camera, hypotheses.front(), context.pose.corner_sigma, refined.marker);
  refined.marker.ambiguity = ambiguity(hypotheses, 1.0);
  return refined;
}

RefinedDock refineDock(const PhotometricContext& context, const DockLayout& layout, const Eigen::Vector3d& up,
                       const std::vector<MarkerEstimate>& markers, const std::vector<DockHypothesis>& dock) {
  if (dock.empty() || dock.front().marker_ids.size() < 2) return {DockOutcome::too_few, dock};
  const std::vector<int>& ids = dock.front().marker_ids;
  const auto rests_on_others = [&ids](const DockHypothesis& h) { return h.marker_ids != ids; };
  if (std::any_of(dock.begin(), dock.end(), rests_on_others)) return {DockOutcome::contradictory, dock};
  std::vector<PatternPlacement> placements;
  for (const int id : ids) {
    const DockMarker& m = layout.markers.at(id);
    placements.push_back({context.patterns.of(id), m.size, m.T_dock_marker()});
  }
  std::vector<Eigen::Isometry3d> initial;
  for (const auto& h : dock) initial.push_back(h.pose);
  double sum = 0.0, known = 0.0;
  for (const MarkerEstimate& m : markers) {
    if (m.image.psf_sd > 0.0) sum += m.image.psf_sd, known += 1.0;
  }
  const double psf_sd = known > 0.0 ? sum / known : context.refiner.parameters().psf_sd;
  auto hypotheses = distinct(
      context.refiner.refineBranches(context.grey, context.camera, placements, initial, {psf_sd, std::nullopt}),
      kExplainedLarge);
  Correspondences corners;
  const auto displaced = [&](const PoseHypothesis& h) {
    return largestDistance(context.camera, layout, markers, ids, h.pose, corners) > kDisplaced;
  };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), displaced), hypotheses.end());
  if (hypotheses.empty()) return {DockOutcome::displaced, dock};
  addModelError(context.camera, corners, context.pose.model_sigma, hypotheses);
  PosePrior prior;
  prior.up = up;
  prior.object_up = Eigen::Vector3d::UnitZ();
  weighByPrior(hypotheses, prior, context.pose.tilt_sigma);
  RefinedDock refined{DockOutcome::refined, {}};
  for (const auto& h : hypotheses) {
    DockHypothesis d;
    static_cast<PoseHypothesis&>(d) = h;
    d.error = dock.front().error;
    d.marker_ids = ids;
    refined.dock.push_back(d);
  }
  dropImprobable(refined.dock, context.pose.min_hypothesis_weight);
  return refined;
}

}  // namespace seater_perception
