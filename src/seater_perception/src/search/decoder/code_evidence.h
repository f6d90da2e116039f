// How much a read code proves, and how much it has to.
#pragma once

#include <optional>
#include <set>
#include <vector>

#include "search/decoder/code_edges.h"
#include "seater_perception/marker_family.h"

namespace seater_perception {

/// -log((1 - correlation^2) worst_bit) + 5 margin - 0.5 covered: see DecodedMarker for what they are. `covered`:
/// samples of border and quiet zone left out.
double codeEvidence(double correlation, double worst_bit, double margin, double covered);

/// What speaks against a code whose bits' edges lie beside their places. `cell`: mean side [px]; `psf_sd`: of the
/// fitted template, which takes what edges are off for blur [cells].
double costOfEdges(const CodeEdges& edges, double cell, double psf_sd);

/// Whether the light cells of a code are one patch, as small things on dark ones are.
bool isOnePatch(const MarkerPattern& pattern);

/// The least evidence of a code.
struct EvidenceThreshold {
  double evidence = 0.0, doubtful_bit = 0.0, one_patch = 0.0;
  /// What codes need some of whose bits are doubtful or turned round, by how many: from one on. Empty: none may be.
  std::vector<double> corrected;

  /// Nothing when too many bits contradict. `cell`: mean side [px]: noise turns bits of small ones only.
  std::optional<double> needed(const BitErrors& errors, double cell) const;
  /// How much more a code of one patch needs. `cell`: mean side [px]: costOfEdges sees no more of small ones.
  double moreOfOnePatch(double cell) const;
};

/// What a family's codes need, when `min_evidence` is what those of DICT_4X4_50 do.
class EvidenceRule {
 public:
  /// `ids`: those looked for; empty: all.
  EvidenceRule(const MarkerFamily& family, const std::set<int>& ids);

  EvidenceThreshold anywhere(double min_evidence) const;
  /// Of a code whose place and id are expected.
  EvidenceThreshold whereExpected(double min_evidence) const;
  /// Whether codes have so few bits that one of a single patch resembles what is commonest.
  bool fewBits() const { return few_bits_; }

 private:
  std::vector<double> corrected(double min_evidence) const;

  double rarity_;  // evidence more than of DICT_4X4_50
  int bits_;
  bool some_ids_, few_bits_;
};

}  // namespace seater_perception
