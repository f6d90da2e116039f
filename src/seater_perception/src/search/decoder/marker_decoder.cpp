#include "search/decoder/marker_decoder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "search/code/pattern_alignment.h"
#include "search/code/template_book.h"
#include "search/decoder/code_evidence.h"

namespace seater_perception {
namespace {

// Before the fit, corners are up to a third of a cell off and correlations low. What is tried then was chosen by hand:
// it costs time (perception_speed), and what is not tried is not found (plain_markers_test, perception_range).
constexpr std::size_t kCandidates = 6;         // codes that are fitted
constexpr std::size_t kCandidatesInGlare = 2;  // codes with which glare is looked for
constexpr double kWorthFittingInGlare = 0.6;
constexpr int kGlareLevel = 4;          // template blur level for that
constexpr double kClearlyBetter = 0.2;  // of correlation: a code so much less likely than the best is not
constexpr double kWorthFitting = 0.5;   // correlation before the fit
constexpr double kPerhapsCode = 0.7;    // part explained by a rough fit
// What true markers and images without markers reach: the table "Evidence of a code" in docs/results/false_finds.md,
// and perception_range (false detections, far end).
constexpr double kSmallestMargin = 0.045;  // of correlation, over the next best code
// Prints cut close on a grey wall (plain_markers_test: down to 0.4 of the contrast below white) or on a white one. The
// limits were chosen by hand; beyond the lower one, the quiet zone would be nearer to the ink than to the paper.
constexpr double kDarkestQuiet = -0.7, kLightestQuiet = 0.5;  // of the contrast, over the print's white
// Chosen by hand; it saves the time of eight more fits. tracker_cases_test draws motion blur up to 2.4 cells.
constexpr double kPerhapsMotion = 0.5;  // part explained without motion
// Drawn prints turned by 60 to 75 deg have 0.78 and more at sides from 32 px on; chosen by hand.
constexpr double kPerhapsSteep = 0.75;  // part explained
// Half a cell's step leaves every place within about the fit's own reach, a third of a cell.
constexpr double kGridStep = 0.5;        // [cells] of the search for a code alone
constexpr double kMostGridSteps = 10.0;  // to each side: bounds the time of a wide `reach`

/// The print's corners of a quadrilateral whose first corner is the print's corner `turn`.
Quad printed(const Quad& quad, int turn) {
  Quad corners;
  for (std::size_t j = 0; j < 4; ++j) corners[j] = quad[(j + 4 - static_cast<std::size_t>(turn)) % 4];
  return corners;
}

}  // namespace

struct MarkerDecoder::Implementation {
  Implementation(const MarkerFamily& family, const std::set<int>& ids)
      : book(family, ids), aligner(book), evidence(family, ids) {}

  TemplateBook book;
  PatternAligner aligner;
  EvidenceRule evidence;

  Alignment candidate(const Sight& sight, const TemplateBook::Candidate& code) const;
  std::optional<DecodedMarker> judge(const ImageLevels& image, const EvidenceThreshold& threshold,
                                     const Alignment& a) const;
  std::optional<DecodedMarker> settle(const ImageLevels& image, const EvidenceThreshold& threshold, Alignment& a) const;
  std::optional<DecodedMarker> steep(const ImageLevels& image, const EvidenceThreshold& threshold,
                                     const Alignment& round) const;
  std::optional<DecodedMarker> motionBlurred(const ImageLevels& image, const EvidenceThreshold& threshold,
                                             const Alignment& still) const;
};

/// Where a code begins that a sight may be of: the samples are the same, in another order.
Alignment MarkerDecoder::Implementation::candidate(const Sight& sight, const TemplateBook::Candidate& code) const {
  Alignment a;
  a.id = code.id;
  a.quad = printed(sight.quad, code.turn);
  const int along = book.grid().along();
  a.samples = {turned(sight.samples.grey, along, code.turn), turned(sight.samples.weights, along, code.turn),
               sight.samples.seen};
  return a;
}

/// Code, margin and bits of an aligned pattern.
std::optional<DecodedMarker> MarkerDecoder::Implementation::judge(const ImageLevels& image,
                                                                  const EvidenceThreshold& threshold,
                                                                  const Alignment& a) const {
  DecodedMarker decoded;
  decoded.id = a.id;
  decoded.corners = a.quad;
  decoded.template_level = a.level;
  decoded.dark = a.fit.light[0];
  decoded.contrast = a.moved || a.free.size() > 0 ? 0.0 : a.fit.gain;
  decoded.steep = a.own && !a.moved;
  decoded.correlation = std::sqrt(std::max(0.0, a.fit.explained));
  if (!aligner.hasBorder(a.samples)) return std::nullopt;
  if (a.fit.quiet < kDarkestQuiet * a.fit.gain || a.fit.quiet > kLightestQuiet * a.fit.gain) return std::nullopt;
  const BitErrors errors = aligner.bitErrors(a);
  decoded.worst_bit = errors.worst;
  decoded.contradicted = errors.contradicted;
  const double cell = meanSide(a.quad) / book.grid().cells();
  const auto needed = threshold.needed(errors, cell);
  if (!needed) return std::nullopt;
  const auto likely = book.compare(a.samples, a.level, 2);
  if (likely.empty() || likely[0].id != a.id || likely[0].turn != 0) return std::nullopt;
  decoded.margin = likely.size() > 1 ? likely[0].correlation - likely[1].correlation : 1.0;
  if (decoded.margin < kSmallestMargin) return std::nullopt;
  decoded.evidence = codeEvidence(decoded.correlation, decoded.worst_bit, decoded.margin, a.covered());
  decoded.surplus = decoded.evidence - *needed;
  if (decoded.surplus < 0.0) return std::nullopt;
  if (!a.moved) {
    const double sd = a.own ? a.own_sd : TemplateBook::kTemplateSd[static_cast<std::size_t>(a.level)];
    double cost = costOfEdges(codeEdges(image, book, a), cell, sd);
    if (evidence.fewBits() && isOnePatch(book.pattern(a.id))) cost += threshold.moreOfOnePatch(cell);
    decoded.evidence -= cost;
    decoded.surplus -= cost;
  }
  if (decoded.surplus < 0.0) return std::nullopt;
  if (a.free.size() == 0) decoded.samples = a.samples;
  return decoded;
}

/// Fits and judges; when it fails, once more without what covers the print.
std::optional<DecodedMarker> MarkerDecoder::Implementation::settle(const ImageLevels& image,
                                                                   const EvidenceThreshold& threshold,
                                                                   Alignment& a) const {
  const auto decoded = judge(image, threshold, a);
  if (decoded || !aligner.leaveOutCovered(a)) return decoded;
  return aligner.align(image, a) ? judge(image, threshold, a) : std::nullopt;
}

/// What looks like the code, but not as a blur that is round on the print would make it: perhaps seen at a steep angle.
std::optional<DecodedMarker> MarkerDecoder::Implementation::steep(const ImageLevels& image,
                                                                  const EvidenceThreshold& threshold,
                                                                  const Alignment& round) const {
  if (round.fit.explained < kPerhapsSteep) return std::nullopt;
  Alignment a = round;
  return aligner.alignSteep(image, a) ? judge(image, threshold, a) : std::nullopt;
}

/// What looks like the code, but not sharp enough: perhaps the image moved.
std::optional<DecodedMarker> MarkerDecoder::Implementation::motionBlurred(const ImageLevels& image,
                                                                          const EvidenceThreshold& threshold,
                                                                          const Alignment& still) const {
  if (still.fit.explained < kPerhapsMotion) return std::nullopt;
  Alignment a = still;
  return aligner.alignMotionBlurred(image, a) ? judge(image, threshold, a) : std::nullopt;
}

MarkerDecoder::MarkerDecoder(const MarkerFamily& family, const std::set<int>& ids)
    : implementation_(new Implementation(family, ids)) {}
MarkerDecoder::~MarkerDecoder() = default;
MarkerDecoder::MarkerDecoder(MarkerDecoder&&) noexcept = default;

int MarkerDecoder::cells() const {
  return implementation_->book.grid().cells();
}

std::optional<Sight> MarkerDecoder::look(const ImageLevels& image, const Quad& quad) const {
  const PatternAligner& aligner = implementation_->aligner;
  Alignment a;
  a.quad = quad;
  if (!aligner.look(image, a) || !aligner.hasBorder(a.samples)) return std::nullopt;
  return Sight{quad, std::move(a.samples)};
}

std::optional<ShadowEdge> MarkerDecoder::shadowEdge(const Sight& sight) const {
  return findShadowEdge(implementation_->book.grid(), sight.samples, sight.quad);
}

std::vector<MarkerDecoder::CodeInGlare> MarkerDecoder::inGlare(const Sight& sight) const {
  const Implementation& self = *implementation_;
  std::vector<CodeInGlare> codes;
  if (!mayHaveGlare(self.book.grid(), sight.samples)) return codes;
  for (const auto& candidate : self.book.compare(sight.samples, Alignment::kStartLevel, kCandidatesInGlare)) {
    if (candidate.correlation < kWorthFittingInGlare) break;
    const Alignment a = self.candidate(sight, candidate);
    const auto glare = findGlare(self.book.grid(), a.samples, self.book.of(a.id, kGlareLevel), a.quad);
    if (glare) codes.push_back({a.id, *glare});
  }
  return codes;
}

std::optional<DecodedMarker> MarkerDecoder::decode(const ImageLevels& image, const Quad& quad,
                                                   double min_evidence) const {
  const auto sight = look(image, quad);
  return sight ? decode(image, *sight, min_evidence) : std::nullopt;
}

std::optional<DecodedMarker> MarkerDecoder::decode(const ImageLevels& image, const Sight& sight,
                                                   double min_evidence) const {
  const Implementation& self = *implementation_;
  if (!self.aligner.showsBits(sight.samples)) return std::nullopt;
  const EvidenceThreshold threshold = self.evidence.anywhere(min_evidence);
  const auto likely = self.book.compare(sight.samples, Alignment::kStartLevel, kCandidates);
  for (const auto& candidate : likely) {
    if (candidate.correlation < std::max(kWorthFitting, likely[0].correlation - kClearlyBetter)) break;
    Alignment a = self.candidate(sight, candidate);
    if (!self.aligner.align(image, a, kPerhapsCode)) continue;
    const Alignment round = a;
    // When another code is as likely, that is seen here too.
    if (const auto decoded = self.settle(image, threshold, a)) return decoded;
    if (const auto decoded = self.steep(image, threshold, round)) return decoded;
  }
  return std::nullopt;
}

std::optional<DecodedMarker> MarkerDecoder::decodeNear(int id, const ImageLevels& image, const Quad& corners,
                                                       double reach, double min_evidence, int template_level) const {
  const Implementation& self = *implementation_;
  if (!self.book.has(id)) return std::nullopt;
  const EvidenceThreshold threshold = self.evidence.whereExpected(min_evidence);
  Alignment a;
  a.id = id;
  a.quad = corners;
  if (template_level >= 0 && template_level < static_cast<int>(TemplateBook::kTemplateSd.size())) {
    Alignment same = a;
    same.level = template_level;
    if (self.aligner.align(image, same)) {
      if (const auto decoded = self.judge(image, threshold, same)) return decoded;
    }
  }
  if (self.aligner.align(image, a)) {
    const Alignment round = a;
    if (const auto decoded = self.settle(image, threshold, a)) return decoded;
    if (const auto decoded = self.steep(image, threshold, round)) return decoded;
    if (const auto decoded = self.motionBlurred(image, threshold, a)) return decoded;
  }
  if (!(reach > 0.0)) return std::nullopt;
  const double step = std::max(1.0, kGridStep * meanSide(corners) / self.book.grid().cells());
  const int steps = static_cast<int>(std::min(kMostGridSteps, reach / step));
  const PatternTemplate& pattern = self.book.of(id, Alignment::kStartLevel);
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
  if (best.fit.explained < PatternAligner::kHopeless || !self.aligner.align(image, best)) return std::nullopt;
  if (const auto decoded = self.settle(image, threshold, best)) return decoded;
  return self.motionBlurred(image, threshold, best);
}

}  // namespace seater_perception
