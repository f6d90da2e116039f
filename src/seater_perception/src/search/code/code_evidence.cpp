#include "search/code/code_evidence.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// The table "Evidence of a code" in docs/results/perception.md; perception_range (false detections, far end) notices.

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
constexpr double kReference = 200.0 / 65536.0;  // of all patterns, those that are codes of DICT_4X4_50

}  // namespace

double codeEvidence(double correlation, double worst_bit, double margin, double covered) {
  const double unexplained = 1.0 - correlation * correlation;
  return -std::log(std::max(1e-9, unexplained * worst_bit)) - kCostOfCovered * covered +
         kWorthOfMargin * std::min(kMostMargin, margin);
}

double EvidenceThreshold::needed(double worst_bit) const {
  return evidence + (worst_bit > kDoubtfulBit ? doubtful_bit : 0.0);
}

/// The fewer of all patterns are codes, the rarer one is seen by chance.
EvidenceRule::EvidenceRule(const MarkerFamily& family, const std::set<int>& ids)
    : some_ids_(!ids.empty() && static_cast<int>(ids.size()) < family.count()) {
  const double patterns = std::exp2(family.bits() * family.bits());
  rarity_ = kEvidencePerDecade * std::log10(4.0 * family.count() / patterns / kReference);
}

EvidenceThreshold EvidenceRule::whereExpected(double min_evidence) const {
  return {std::max(std::min(min_evidence, kLeastEvidence), min_evidence + rarity_), 0.0};
}

EvidenceThreshold EvidenceRule::anywhere(double min_evidence) const {
  return {whereExpected(min_evidence).evidence + (some_ids_ ? kSomeIds : 0.0), kEvidencePerDecade};
}

}  // namespace seater_perception
