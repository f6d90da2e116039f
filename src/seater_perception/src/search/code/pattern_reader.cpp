#include "search/code/pattern_reader.h"

#include <algorithm>
#include <cmath>

#include "search/code/pattern_alignment.h"
#include "search/code/template_book.h"

namespace seater_perception {
namespace {

constexpr std::size_t kCandidates = 6;  // codes that are fitted
constexpr double kClearlyBetter = 0.2;  // of correlation: a code so much less likely than the best is not
constexpr double kWorthFitting = 0.5;   // correlation before the fit
// What true markers and images without markers reach: docs/perception.md.
constexpr double kSmallestMargin = 0.045;  // of correlation, over the next best code
constexpr double kLargestBitError = 0.9;   // of what turns a bit round
constexpr double kCostOfCovered = 0.25;    // of evidence, for each sample left out: what is chosen proves less
constexpr double kDarkestQuiet = -0.7, kLightestQuiet = 0.5;  // of the contrast, over the print's white
constexpr double kPerhapsMoving = 0.5;                        // part explained without motion
constexpr double kHopeless = 0.2;                             // part explained after some steps
constexpr double kGridStep = 0.5, kMostGridSteps = 10.0;      // [cells] and number: search for a code alone

/// The print's corners of a quadrilateral whose first corner is the print's corner `turn`.
Quad printed(const Quad& quad, int turn) {
  Quad corners;
  for (std::size_t j = 0; j < 4; ++j) corners[j] = quad[(j + 4 - static_cast<std::size_t>(turn)) % 4];
  return corners;
}

}  // namespace

struct PatternReader::Implementation {
  Implementation(const MarkerFamily& family, const std::set<int>& ids) : book(family, ids), aligner(book) {}

  TemplateBook book;
  PatternAligner aligner;

  std::optional<PatternReading> judge(double min_evidence, const Alignment& a) const;
  std::optional<PatternReading> settle(const ImageLevels& image, double min_evidence, Alignment& a) const;
  std::optional<PatternReading> moving(const ImageLevels& image, double min_evidence, const Alignment& still) const;
};

/// Code, margin and bits of an aligned pattern.
std::optional<PatternReading> PatternReader::Implementation::judge(double min_evidence, const Alignment& a) const {
  PatternReading reading;
  reading.id = a.id;
  reading.corners = a.quad;
  reading.blur = a.blur;
  reading.dark = a.fit.light[0];
  reading.contrast = a.moving || a.free.size() > 0 ? 0.0 : a.fit.gain;
  reading.correlation = std::sqrt(std::max(0.0, a.fit.explained));
  if (!aligner.hasBorder(a.samples)) return std::nullopt;
  if (a.fit.quiet < kDarkestQuiet * a.fit.gain || a.fit.quiet > kLightestQuiet * a.fit.gain) return std::nullopt;
  reading.worst_bit = aligner.worstBit(a);
  if (!(reading.worst_bit < kLargestBitError)) return std::nullopt;
  const double unexplained = 1.0 - reading.correlation * reading.correlation;
  reading.evidence = -std::log(std::max(1e-9, unexplained * reading.worst_bit)) - kCostOfCovered * a.covered();
  if (reading.evidence < min_evidence) return std::nullopt;
  const auto likely = book.compare(a.samples, a.blur, 2);
  if (likely.empty() || likely[0].id != a.id || likely[0].turn != 0) return std::nullopt;
  reading.margin = likely.size() > 1 ? likely[0].correlation - likely[1].correlation : 1.0;
  if (reading.margin < kSmallestMargin) return std::nullopt;
  return reading;
}

/// Fits and judges; when it fails, once more without what covers the print.
std::optional<PatternReading> PatternReader::Implementation::settle(const ImageLevels& image, double min_evidence,
                                                                    Alignment& a) const {
  const auto reading = judge(min_evidence, a);
  if (reading || !aligner.leaveOutCovered(a)) return reading;
  return aligner.align(image, a) ? judge(min_evidence, a) : std::nullopt;
}

/// What looks like the code, but not sharp enough: perhaps the image moved.
std::optional<PatternReading> PatternReader::Implementation::moving(const ImageLevels& image, double min_evidence,
                                                                    const Alignment& still) const {
  if (still.fit.explained < kPerhapsMoving) return std::nullopt;
  Alignment a = still;
  return aligner.alignMoving(image, a) ? judge(min_evidence, a) : std::nullopt;
}

PatternReader::PatternReader(const MarkerFamily& family, const std::set<int>& ids)
    : implementation_(new Implementation(family, ids)) {}
PatternReader::~PatternReader() = default;
PatternReader::PatternReader(PatternReader&&) noexcept = default;

int PatternReader::cells() const {
  return implementation_->book.grid().cells();
}

std::optional<ShadowEdge> PatternReader::shadowEdge(const ImageLevels& image, const Quad& quad) const {
  const PatternAligner& aligner = implementation_->aligner;
  Alignment a;
  a.quad = quad;
  if (!aligner.look(image, a) || !aligner.hasBorder(a.samples)) return std::nullopt;
  return findShadowEdge(implementation_->book.grid(), a.samples, quad);
}

std::optional<PatternReading> PatternReader::read(const ImageLevels& image, const Quad& quad,
                                                  double min_evidence) const {
  const Implementation& self = *implementation_;
  Alignment start;
  start.quad = quad;
  if (!self.aligner.look(image, start) || !self.aligner.hasBorder(start.samples)) return std::nullopt;
  const auto likely = self.book.compare(start.samples, Alignment::kStartBlur, kCandidates);
  for (const auto& candidate : likely) {
    if (candidate.correlation < std::max(kWorthFitting, likely[0].correlation - kClearlyBetter)) break;
    Alignment a;
    a.id = candidate.id;
    a.quad = printed(quad, candidate.turn);
    if (!self.aligner.align(image, a)) continue;
    // When another code is as likely, that is seen here too.
    if (const auto reading = self.settle(image, min_evidence, a)) return reading;
  }
  return std::nullopt;
}

std::optional<PatternReading> PatternReader::follow(int id, const ImageLevels& image, const Quad& corners, double reach,
                                                    double min_evidence, int blur) const {
  const Implementation& self = *implementation_;
  if (!self.book.has(id)) return std::nullopt;
  Alignment a;
  a.id = id;
  a.quad = corners;
  if (blur >= 0 && blur < static_cast<int>(TemplateBook::kBlurs.size())) {
    Alignment same = a;
    same.blur = blur;
    if (self.aligner.align(image, same)) {
      if (const auto reading = self.judge(min_evidence, same)) return reading;
    }
  }
  if (self.aligner.align(image, a)) {
    if (const auto reading = self.settle(image, min_evidence, a)) return reading;
    if (const auto reading = self.moving(image, min_evidence, a)) return reading;
  }
  if (!(reach > 0.0)) return std::nullopt;
  const double step = std::max(1.0, kGridStep * meanSide(corners) / self.book.grid().cells());
  const int steps = static_cast<int>(std::min(kMostGridSteps, reach / step));
  const PatternTemplate& pattern = self.book.of(id, Alignment::kStartBlur);
  Alignment best = a;
  best.fit.explained = 0.0;
  for (int y = -steps; y <= steps; ++y) {
    for (int x = -steps; x <= steps; ++x) {
      Alignment there;
      there.id = id;
      there.quad = corners;
      for (auto& c : there.quad) c += step * Eigen::Vector2d(x, y);
      if (!self.aligner.look(image, there)) continue;
      const auto fit = pattern.fit(there.samples.grey, there.weights(), false);
      if (fit && fit->gain > 0.0 && fit->explained > best.fit.explained) best = there, best.fit = *fit;
    }
  }
  if (best.fit.explained < kHopeless || !self.aligner.align(image, best)) return std::nullopt;
  if (const auto reading = self.settle(image, min_evidence, best)) return reading;
  return self.moving(image, min_evidence, best);
}

}  // namespace seater_perception
