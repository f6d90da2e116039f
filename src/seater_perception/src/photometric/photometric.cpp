#include "seater_perception/photometric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "photometric/branch_fit.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

// Chosen by hand where no reason is given; photometric_test and `perception_accuracy` notice.
constexpr double kFineMargin = 0.25;    // [px] the approach ends nearer than this
constexpr double kNoEnd = 1e6;          // [grey levels] of a sensor that does not clip
constexpr int kSparse = 1000;           // pixels of an approach
constexpr double kClearlyWorse = 30.0;  // of chi-squared: exp(-15), 1 in 3 million
// Samples are collected anew when the point spread function has grown to more than this.
constexpr double kWiderPsf = 1.2, kWiderPsfFloor = 0.1;  // [of that they are meant for], [px]
constexpr int kRounds = 4;  // of collecting pixels: the approach, then again while a marker leaves its band

using Placements = std::vector<PatternPlacement>;

PsfModel psfModelOf(const std::string& name) {
  if (name == "given") return PsfModel::given;
  if (name == "estimated") return PsfModel::isotropic;
  if (name == "directed") return PsfModel::anisotropic;
  throw ConfigurationError("photometric/blur: is '" + name + "', must be given, estimated or directed");
}

/// Largest movement of a marker's corner in the image; infinite when one is behind the camera.
struct Movement {
  double pixels = 0.0;
  double sides = 0.0;  ///< of its marker
};

Movement movement(const CameraModel& camera, const Placements& placements, const Eigen::Isometry3d& a,
                  const Eigen::Isometry3d& b) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Movement largest;
  for (const PatternPlacement& p : placements) {
    std::optional<Eigen::Vector2d> previous;
    double moved = 0.0, side = 0.0;
    for (const Eigen::Vector3d& corner : markerCorners(p.size)) {
      const auto from = camera.project(a * p.T_object_marker * corner),
                 to = camera.project(b * p.T_object_marker * corner);
      if (!from || !to) return {kInfinity, kInfinity};
      moved = std::max(moved, (*from - *to).norm());
      if (previous) side = std::max(side, (*from - *previous).norm());
      previous = from;
    }
    largest.pixels = std::max(largest.pixels, moved);
    largest.sides = std::max(largest.sides, moved / std::max(1e-6, side));
  }
  return largest;
}

/// What all fits of one call share.
struct FitContext {
  const cv::Mat& grey;
  const CameraModel& camera;
  const Placements& placements;
  const std::vector<Eigen::Isometry3d>& initial;
  const PhotometricStart& start;
};

/// Fills in the rest of the result, or takes everything back when it cannot be relied on.
void conclude(const FitContext& context, const PhotometricParameters& parameters, const Eigen::Isometry3d& initial,
              BranchFit& fit) {
  PhotometricResult& result = fit.result;
  const Movement moved = movement(context.camera, context.placements, initial, fit.state.pose);
  if (!fit.failed && !(moved.sides < parameters.max_shift)) fit.fail("moved too far from the initial pose");
  if (!fit.failed && result.inlier_fraction < parameters.min_inlier_share) fit.fail("too few inliers");
  for (const Brightness& b : fit.state.brightness) {
    if (!fit.failed && b.used && b.gain < parameters.min_contrast) fit.fail("too little contrast");
  }
  const SpreadCovariance& s = fit.state.psf;
  const double mean = 0.5 * (s.uu + s.vv), half = std::hypot(0.5 * (s.uu - s.vv), s.uv), area = areaVariance(1);
  result.psf_sd = std::sqrt(std::sqrt(std::max(0.0, mean + half) * std::max(0.0, mean - half)));
  result.psf_elongation = std::sqrt((mean + half + area) / std::max(1e-3, mean - half + area));
  const bool finite = fit.state.pose.matrix().allFinite() && result.covariance.allFinite() &&
                      std::isfinite(result.noise_sd + result.psf_sd + result.psf_elongation);
  if (!fit.failed && !finite) fit.fail("not finite");
  if (fit.failed) {
    PhotometricResult nothing;
    nothing.failure = result.failure;
    nothing.iterations = result.iterations;
    nothing.pose = initial;
    nothing.brightness.assign(context.placements.size(), {});
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

double psfSd(const PhotometricState& state) {
  return std::sqrt(std::max(0.0, 0.5 * (state.psf.uu + state.psf.vv)));
}

}  // namespace

struct PhotometricRefiner::Workspace {
  explicit Workspace(const PhotometricParameters& values)
      : parameters(values), psf_model(psfModelOf(values.psf_model)) {}

  std::vector<BranchFit> fitAll(const FitContext& context);

  const PhotometricParameters parameters;

  struct Round {
    double margin = 0.0;  ///< [px] how far poses may be off
    int most = 0;         ///< pixels of a marker
    bool slopes = false;  ///< of brightness are fitted too
  };
  std::vector<BranchFit> fitClipped(const FitContext& context, const ClipRange& range);
  std::vector<BranchFit> begin(const FitContext& context, const ClipRange& range) const;
  double collectAll(const FitContext& context, const std::vector<BranchFit>& fits, const Round& round);
  static void finishAll(const PhotometricProblem& problem, const PhotometricStart& start, bool begin,
                        std::vector<BranchFit>& fits);

  const PsfModel psf_model;
  SampleCollector collector;
  EvaluationPool pool;
  std::vector<MarkerSamples> samples;
};

/// Pixels of all markers, the same for all fits; returns the widest lens' point spread function of the fits, for which
/// they are meant [px].
double PhotometricRefiner::Workspace::collectAll(const FitContext& context, const std::vector<BranchFit>& fits,
                                                 const Round& round) {
  double psf_sd = 0.0, apart = 0.0;
  const BranchFit* first = nullptr;
  for (const BranchFit& fit : fits) {
    if (fit.failed) continue;
    if (!first) first = &fit;
    psf_sd = std::max(psf_sd, psfSd(fit.state));
    apart = std::max(apart, movement(context.camera, context.placements, first->state.pose, fit.state.pose).pixels);
  }
  samples.resize(context.placements.size());
  for (std::size_t m = 0; m < samples.size(); ++m) {
    samples[m].clear();
    if (!first) continue;
    const PatternPlacement& placement = context.placements[m];
    collector.collect(context.grey, context.camera, placement, first->state.pose * placement.T_object_marker, psf_sd,
                      round.margin + apart, round.most, round.slopes, parameters, samples[m]);
  }
  return psf_sd;
}

/// All fits from where they are to their minima; those that cannot win end at the first look.
void PhotometricRefiner::Workspace::finishAll(const PhotometricProblem& problem, const PhotometricStart& start,
                                              bool begin, std::vector<BranchFit>& fits) {
  const BranchFit* best = nullptr;
  for (BranchFit& fit : fits) {
    if (fit.failed) continue;
    if (start.brightness) {
      if (begin) fit.start(problem, *start.brightness, best);
    } else {
      if (begin) fit.start(problem);
      std::optional<Evaluation> look;
      if (!fit.failed) look = fit.firstLook(problem);
      if (!fit.failed && best && fit.clearlyWorseThan(*best)) {
        fit.hopeless = true;
        fit.fail("clearly worse than another initial pose's");
      }
      if (!fit.failed && best && fit.sameAs(*best, *look)) fit.fail("same as another initial pose's");
    }
    if (!fit.failed) fit.finish(problem);
    if (!fit.failed && !best) best = &fit;
  }
}

/// A drawn image may have no grey level between black and white, both at the sensor's ends. To say that all of it is
/// clipped explains it best, and tells nothing of the pose: then without clipping.
std::vector<BranchFit> PhotometricRefiner::Workspace::fitAll(const FitContext& context) {
  requireImage(context.grey, context.camera);
  const double limit = parameters.saturation > 0.0      ? parameters.saturation
                       : context.grey.depth() == CV_16U ? 65535.0
                                                        : 255.0;
  auto fits = fitClipped(context, {0.0, limit});
  const bool blind =
      std::any_of(fits.begin(), fits.end(), [](const BranchFit& fit) { return fit.failed && fit.blind; });
  const bool none = std::all_of(fits.begin(), fits.end(), [](const BranchFit& fit) { return fit.failed; });
  if (blind && none) fits = fitClipped(context, {-kNoEnd, kNoEnd});
  return fits;
}

/// All fits at their initial poses; those that cannot be have failed.
std::vector<BranchFit> PhotometricRefiner::Workspace::begin(const FitContext& context, const ClipRange& range) const {
  const double sd =
      context.start.psf_sd > 0.0 && psf_model != PsfModel::given ? context.start.psf_sd : parameters.psf_sd;
  std::vector<BranchFit> fits(context.initial.size(), BranchFit(parameters, range, context.start.whole));
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Eigen::Isometry3d& initial = context.initial[i];
    fits[i].state.pose = initial;
    fits[i].state.psf = {sd * sd, 0.0, sd * sd};
    const bool seen = std::isfinite(movement(context.camera, context.placements, initial, initial).sides);
    if (!initial.matrix().allFinite() || !seen) fits[i].fail("impossible initial pose");
  }
  return fits;
}

/// All initial poses on the same pixels.
std::vector<BranchFit> PhotometricRefiner::Workspace::fitClipped(const FitContext& context, const ClipRange& range) {
  std::vector<BranchFit> fits = begin(context, range);
  const bool near = context.start.psf_sd > 0.0;
  for (int k = near ? 1 : 0; k < kRounds; ++k) {
    const bool first = k == 0;
    const Round round{first ? parameters.margin : kFineMargin,
                      first ? std::min(kSparse, parameters.max_pixels) : parameters.max_pixels,
                      parameters.illumination_slope && !first};
    const double psf_sd = collectAll(context, fits, round);
    const PhotometricProblem problem(context.camera, context.placements, samples, psf_model, round.slopes, pool);
    std::vector<Eigen::Isometry3d> before;
    for (BranchFit& fit : fits) {
      before.push_back(fit.state.pose);
      if (first && !fit.failed) fit.approach(problem);
    }
    if (!first) finishAll(problem, context.start, near && k == 1, fits);
    bool again = first;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (fits[i].failed) continue;
      const double moved = movement(context.camera, context.placements, before[i], fits[i].state.pose).pixels,
                   now = psfSd(fits[i].state);
      again |= moved > round.margin || raysPerPixel(now) != raysPerPixel(psf_sd) ||
               now > kWiderPsf * psf_sd + kWiderPsfFloor;
    }
    if (!again) break;
  }
  for (std::size_t i = 0; i < fits.size(); ++i) conclude(context, parameters, context.initial[i], fits[i]);
  if (samples.size() != 1) return fits;
  const auto better = [](const BranchFit& a, const BranchFit& b) {
    return !a.failed && (b.failed || a.result.cost < b.result.cost);
  };
  const auto best = std::min_element(fits.begin(), fits.end(), better);
  if (best == fits.end() || best->failed) return fits;
  best->tellShifts({context.camera, context.placements, samples, psf_model, parameters.illumination_slope, pool});
  return fits;
}

PhotometricRefiner::PhotometricRefiner(const PhotometricParameters& parameters)
    : workspace_(std::make_unique<Workspace>(parameters)) {}

PhotometricRefiner::~PhotometricRefiner() = default;
PhotometricRefiner::PhotometricRefiner(PhotometricRefiner&&) noexcept = default;

const PhotometricParameters& PhotometricRefiner::parameters() const {
  return workspace_->parameters;
}

PhotometricResult PhotometricRefiner::refine(const cv::Mat& grey, const CameraModel& camera,
                                             const Placements& placements, const Eigen::Isometry3d& initial) {
  return workspace_->fitAll({grey, camera, placements, {initial}, {}}).front().result;
}

std::vector<PhotometricBranch> PhotometricRefiner::refineBranches(const cv::Mat& grey, const CameraModel& camera,
                                                                  const Placements& placements,
                                                                  const std::vector<Eigen::Isometry3d>& initial,
                                                                  const PhotometricStart& start) {
  std::vector<PhotometricBranch> branches;
  double sd = std::numeric_limits<double>::infinity();
  for (const BranchFit& fit : workspace_->fitAll({grey, camera, placements, initial, start})) {
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
