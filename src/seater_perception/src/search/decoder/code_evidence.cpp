#include "search/decoder/code_evidence.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// The table "Evidence of a code" in docs/results/false_finds.md; perception_range (false detections, far end) notices.

// Above it, a bit is doubtful, and the code has to prove a decade (kEvidencePerDecade) more. Marks of other
// dictionaries have one such bit at least; of the markers of photographs with so little evidence, none has.
constexpr double kDoubtfulBit = 0.7;
// Of evidence, for each sample left out: what is chosen proves less. At half of it, boards of squares are taken for
// codes that are nearly one (DICT_4X4_50 has such: 17).
constexpr double kCostOfCovered = 0.5;
// A code that stands clear of all others is proved, however a camera has changed its edges. The more codes there are to
// choose from, the smaller that margin; the dock's few ids must not prove more than all of a family would.
constexpr double kWorthOfMargin = 5.0, kMostMargin = 0.15;
// How much evidence less makes a false code ten times as frequent (same table), and where bits alone decide: no image
// without markers has ever shown a code of 25 bits or more with all bits on their sides and this evidence.
constexpr double kEvidencePerDecade = 0.6, kLeastEvidence = 2.5;
// Where only some ids are looked for, which of the others is likelier is not seen, and the margin proves less. Chosen
// by hand: marks of other dictionaries reach 0.37 more than with all ids.
constexpr double kSomeIds = 0.4;
// Of fewer bits, none may be turned round, and a code of one patch needs more.
constexpr int kEnoughBits = 25;
// A cell from 3 px on has a pixel that no edge of it touches, wherever it lies: what that shows is its bit. In smaller
// ones, a camera that cuts off or stretches grey levels turns bits round (docs/results/photographs.md, Kinds of
// cameras). Codes of many bits are proved by the others: as many are allowed for as half of what 36h11 can correct (5).
// Where none is, codes of 36 bits with three such ones reach an evidence of 1.8 (docs/results/false_finds.md).
constexpr double kWholePixel = 3.0;  // [px]
constexpr int kMostCorrected = 3;
constexpr double kLeastCorrected = 1.8;
// Edges of what only resembles a code lie beside their places, and the fit takes that for blur. By the spread of grey
// levels on them, where the image has room to show it (cells from 4 to 5 px on) and the fit is blurred (from 0.12 to
// 0.2 cells on; a sharp one has lost its evidence already), and by how far that is in cells (3 to 4 px: of less, noise
// decides). The table "Edges of a code" in docs/results/false_finds.md.
constexpr double kSpread = 0.17, kCostOfSpread = 150.0, kRoom = 4.0;              // [contrast], [1/contrast], [px]
constexpr double kSharp = 0.12, kBlurred = 0.2;                                   // [cells]
constexpr double kDisplaced = 0.13, kCostOfDisplacement = 20.0, kSomeRoom = 3.0;  // [cells], [1/cell], [px]
// Grey level's change over the displacement of an edge, where a Gaussian of 1 cell blurs it: 1 / sqrt(2 pi).
constexpr double kSlope = 0.3989;
// A dark square with a light spot is the commonest thing that resembles a code. A patch of 2 x 2 cells has eight edges,
// of 2 x 3 or 1 x 4 ten; DICT_4X4_50 has one such code (17), which all false finds on drawn marks that are not steep,
// and the only one on photographs and paintings, were of. As long as costOfEdges has not all of its room, it needs two
// decades more.
constexpr int kEdgesOfPatch = 10;
constexpr double kMoreOfPatch = 1.2;
constexpr double kReference = 200.0 / 65536.0;  // of all patterns, those that are codes of DICT_4X4_50

}  // namespace

double codeEvidence(double correlation, double worst_bit, double margin, double covered) {
  const double unexplained = 1.0 - correlation * correlation;
  return -std::log(std::max(1e-9, unexplained * worst_bit)) - kCostOfCovered * covered +
         kWorthOfMargin * std::min(kMostMargin, margin);
}

double costOfEdges(const CodeEdges& edges, double cell, double psf_sd) {
  const auto from = [](double start, double x) { return std::clamp(x - start, 0.0, 1.0); };
  const double blurred = std::clamp((psf_sd - kSharp) / (kBlurred - kSharp), 0.0, 1.0);
  const double displaced = edges.spread * psf_sd / kSlope;
  return kCostOfSpread * from(kRoom, cell) * blurred * std::max(0.0, edges.spread - kSpread) +
         kCostOfDisplacement * from(kSomeRoom, cell) * std::max(0.0, displaced - kDisplaced);
}

bool isOnePatch(const MarkerPattern& pattern) {
  int edges = 0;
  for (int row = 0; row < pattern.cells(); ++row) {
    for (int column = 0; column < pattern.cells(); ++column) {
      if (column + 1 < pattern.cells()) edges += pattern.at(column, row) != pattern.at(column + 1, row) ? 1 : 0;
      if (row + 1 < pattern.cells()) edges += pattern.at(column, row) != pattern.at(column, row + 1) ? 1 : 0;
    }
  }
  return edges <= kEdgesOfPatch;
}

double EvidenceThreshold::moreOfOnePatch(double cell) const {
  return one_patch * (1.0 - std::clamp(cell - kRoom, 0.0, 1.0));
}

std::optional<double> EvidenceThreshold::needed(const BitErrors& errors, double cell) const {
  const bool doubtful = errors.worst > kDoubtfulBit, small = cell < kWholePixel;
  const double plain = evidence + (doubtful ? doubtful_bit : 0.0);
  if (errors.contradicted == 0) return doubtful && small && !corrected.empty() ? std::min(plain, corrected[0]) : plain;
  const auto bits = static_cast<std::size_t>(errors.contradicted);
  if (!small || bits > corrected.size()) return std::nullopt;
  return corrected[bits - 1];
}

/// The fewer of all patterns are codes, the rarer one is seen by chance.
EvidenceRule::EvidenceRule(const MarkerFamily& family, const std::set<int>& ids)
    : bits_(family.bits() * family.bits()),
      some_ids_(!ids.empty() && static_cast<int>(ids.size()) < family.count()),
      few_bits_(bits_ < kEnoughBits) {
  const double patterns = std::exp2(bits_);
  rarity_ = kEvidencePerDecade * std::log10(4.0 * family.count() / patterns / kReference);
}

/// With every bit that may be wrong, more patterns pass for a code: as many as there are choices of these bits.
std::vector<double> EvidenceRule::corrected(double min_evidence) const {
  std::vector<double> needed;
  if (few_bits_) return needed;
  double choices = 1.0, patterns = 1.0;
  for (int wrong = 1; wrong <= kMostCorrected; ++wrong) {
    choices *= static_cast<double>(bits_ - wrong + 1) / wrong;
    patterns += choices;
    const double rarer = min_evidence + rarity_ + kEvidencePerDecade * std::log10(patterns);
    needed.push_back(std::max(std::min(min_evidence, kLeastCorrected), rarer));
  }
  return needed;
}

EvidenceThreshold EvidenceRule::whereExpected(double min_evidence) const {
  const double least = std::max(std::min(min_evidence, kLeastEvidence), min_evidence + rarity_);
  return {least, 0.0, 0.0, corrected(min_evidence)};
}

EvidenceThreshold EvidenceRule::anywhere(double min_evidence) const {
  const double more = some_ids_ ? kSomeIds : 0.0;
  EvidenceThreshold threshold = whereExpected(min_evidence);
  threshold.evidence += more;
  threshold.doubtful_bit = kEvidencePerDecade;
  threshold.one_patch = kMoreOfPatch;
  for (double& needed : threshold.corrected) needed += more;
  return threshold;
}

}  // namespace seater_perception
