#include "photometric/photometric_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "photometric/branch_seeds.h"
#include "seater_perception/dock_layout.h"

namespace seater_perception {
namespace {

// Part of the image's variance that the pattern has to explain: a small marker has to be proved by it, a large one
// has been read bit by bit and may be partly covered.
constexpr double kExplainedSmall = 0.9, kExplainedLarge = 0.85;
constexpr double kLargeSide = 40.0;                         // [px]
constexpr double kBeyondScale = 0.15, kLargestBlur = 0.95;  // of the range of grey levels; of a cell
// Residuals at edges over those of flat pixels, and distance from the fitted edges' corners over its standard
// deviation: from here on, the print is not what the model says.
constexpr double kMisfit = 1.8, kContradiction = 1.0;
constexpr double kCoarseCorners = 0.25;   // cells
constexpr double kBlurredCorners = 0.25;  // standard deviations of the blur
constexpr double kClipped = 0.05;         // share of the pixels
constexpr double kShadowSigma = 0.06;     // [px] of a corner: what taking away a shadow's edge leaves
constexpr double kLargestGap = 0.3;       // [px] rms, between a marker's own corners and those of the joint pose

/// Grey levels that the sensor could have seen, and a blur that leaves cells to be told apart.
bool plausible(const PhotometricResult& result, double side, int cells, double full_scale) {
  // Where the image is clipped, the sensor does not know how dark or light it would have been.
  const auto beyond = [full_scale](double clipped) { return (clipped > kClipped ? 1.0 : kBeyondScale) * full_scale; };
  const double least = -beyond(result.clipped_low), most = full_scale + beyond(result.clipped_high);
  for (const Brightness& b : result.brightness) {
    if (b.used && (b.offset < least || b.offset + b.gain > most)) return false;
  }
  return result.blur_sd < kLargestBlur * side / cells;
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
double gap(const CameraModel& camera, const DockLayout& layout, const std::vector<MarkerEstimate>& markers,
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

}  // namespace

const MarkerPattern& PatternBook::of(int id) {
  const auto known = patterns_.find(id);
  if (known != patterns_.end()) return known->second;
  return patterns_.emplace(id, MarkerPattern::fromDictionary(dictionary_, id)).first->second;
}

bool refinePhotometrically(const cv::Mat& grey, const CameraModel& camera, const MarkerPattern& pattern,
                           PhotometricRefiner& refiner, const PosePrior& prior, const PoseParameters& parameters,
                           MarkerEstimate& marker, bool followed) {
  const std::vector<PatternPlacement> placement{{pattern, marker.size, Eigen::Isometry3d::Identity()}};
  const double explained = marker.image.side() < kLargeSide ? kExplainedSmall : kExplainedLarge;
  const double blur = marker.image.edges_fitted || followed ? marker.image.blur_sd : 0.0;
  const double full_scale = grey.depth() == CV_16U ? 65535.0 : 255.0;
  std::optional<Brightness> known;
  if (followed) known = Brightness{true, marker.image.dark, marker.image.contrast, 0.0, 0.0, 0.0};
  double misfit = 0.0, fitted_blur = 0.0;
  std::vector<PhotometricBranch> branches;
  const auto fitSeeds = [&](PhotometricRefiner& by, const std::vector<Eigen::Isometry3d>& seeds,
                            const PhotometricStart& start) {
    branches = by.refineBranches(grey, camera, placement, seeds, start);
    double best = std::numeric_limits<double>::infinity();
    for (auto& b : branches) {
      b.result.converged = b.result.converged && plausible(b.result, marker.image.side(), pattern.cells(), full_scale);
      if (!b.result.converged || b.chi_square >= best) continue;
      best = b.chi_square;
      misfit = b.result.flat_noise > 0.0 ? b.result.noise_sd / b.result.flat_noise : 0.0;
      fitted_blur = b.result.blur_sd;
    }
    return distinct(branches, explained);
  };
  const auto fit = [&](PhotometricRefiner& by, double known_blur) {
    auto found = fitSeeds(by, openSeeds(marker), {known_blur, known});
    if (!otherBranchOpen(marker, branches, found)) return found;
    const double near_blur = known_blur > 0.0 ? known_blur : by.parameters().blur_sd;
    const auto both = fitSeeds(by, steepSeeds(found.front().pose), {near_blur, std::nullopt});
    return both.empty() ? found : both;
  };
  auto hypotheses = fit(refiner, blur);
  if (followed && (hypotheses.empty() || misfit > kMisfit)) return false;
  if (hypotheses.empty() && blur > 0.0) hypotheses = fit(refiner, 0.0);
  if (hypotheses.empty() && marker.image.side() > kLargeSide) {
    // The quiet zone may be darker than the print's white (cut close and pasted on a wall): the print alone, then.
    PhotometricParameters print_only = refiner.parameters();
    print_only.quiet_zone = 0.0;
    PhotometricRefiner refiner_of_print(print_only);
    hypotheses = fit(refiner_of_print, blur);
  }
  if (hypotheses.empty()) return false;
  Correspondences seen;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!seen.add(markerCorners(marker.size)[i], marker.image.corners[i], 1.0, camera)) return false;
  }
  addModelError(camera, seen, std::max(parameters.model_sigma, marker.image.shadow ? kShadowSigma : 0.0), hypotheses);
  for (auto& h : hypotheses) h.error = reprojectionError(camera, seen, h.pose);
  // Corners that no edge confirms may be some tenths of a cell off, those of blurred edges some tenths of the blur.
  const double coarse = marker.image.edges_fitted ? kBlurredCorners * marker.image.blur_sd
                                                  : kCoarseCorners * marker.image.side() / pattern.cells();
  const double limit = largestError(marker.image.side(), parameters) + coarse;
  const auto unbelievable = [&](const PoseHypothesis& h) { return !meaningful(h) || h.error > limit; };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), unbelievable), hypotheses.end());
  if (hypotheses.empty()) return false;
  weighByPrior(hypotheses, prior, parameters.tilt_sigma);
  // A print that is bent or has grown cells: where the model does not hold, the outer edges are what its size means.
  const double contradiction = kContradiction * parameters.corner_sigma;
  if (marker.image.edges_fitted && misfit > kMisfit && hypotheses.front().error > contradiction) return true;
  marker.hypotheses = hypotheses;
  marker.image.blur_sd = fitted_blur;
  placeCorners(camera, hypotheses.front(), parameters.corner_sigma, marker);
  marker.ambiguity = 0.0;
  if (hypotheses.size() > 1) {
    marker.ambiguity = std::exp(std::min(5.0, 0.5 * (hypotheses[0].chi_squared - hypotheses[1].chi_squared)));
  }
  return true;
}

void refineBundle(const cv::Mat& grey, const CameraModel& camera, PatternBook& patterns, PhotometricRefiner& refiner,
                  const DockLayout& layout, const Eigen::Vector3d& up, const PoseParameters& parameters,
                  const std::vector<MarkerEstimate>& markers, std::vector<DockHypothesis>& dock) {
  if (dock.empty() || dock.front().marker_ids.size() < 2) return;
  for (const auto& h : dock) {
    if (h.marker_ids != dock.front().marker_ids) return;  // they contradict each other
  }
  std::vector<PatternPlacement> placements;
  for (const int id : dock.front().marker_ids) {
    const DockMarker& m = layout.markers.at(id);
    placements.push_back({patterns.of(id), m.size, m.T_dock_marker()});
  }
  std::vector<Eigen::Isometry3d> seeds;
  for (const auto& h : dock) seeds.push_back(h.pose);
  double blur = 0.0, fitted = 0.0;
  for (const MarkerEstimate& m : markers) {
    if (m.image.blur_sd > 0.0) blur += m.image.blur_sd, fitted += 1.0;
  }
  const auto branches = refiner.refineBranches(grey, camera, placements, seeds,
                                               {fitted > 0.0 ? blur / fitted : refiner.parameters().blur_sd, {}});
  auto hypotheses = distinct(branches, kExplainedLarge);
  const auto ids = dock.front().marker_ids;
  Correspondences corners;
  hypotheses.erase(
      std::remove_if(hypotheses.begin(), hypotheses.end(),
                     [&](const auto& h) { return gap(camera, layout, markers, ids, h.pose, corners) > kLargestGap; }),
      hypotheses.end());
  if (hypotheses.empty()) return;
  addModelError(camera, corners, parameters.model_sigma, hypotheses);
  PosePrior prior;
  prior.up = up;
  prior.object_up = Eigen::Vector3d::UnitZ();
  weighByPrior(hypotheses, prior, parameters.tilt_sigma);
  const double error = dock.front().error;
  dock.clear();
  for (const auto& h : hypotheses) {
    DockHypothesis d;
    static_cast<PoseHypothesis&>(d) = h;
    d.error = error;
    d.marker_ids = ids;
    dock.push_back(d);
  }
  dropImprobable(dock, parameters.min_hypothesis_weight);
}

}  // namespace seater_perception
