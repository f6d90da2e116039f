#pragma once

#include <optional>
#include <set>
#include <vector>

#include "search/decoder/marker_decoder.h"
#include "search/marker_detector.h"
#include "search/outline/quad_search.h"

namespace seater_perception {

// Two decades of false codes (code_evidence.cpp): what was read with less beyond the threshold is looked at twice.
constexpr double kDecades = 1.2;
// Chosen by hand: smaller than a marker of the default `min_side` with its quiet zone.
constexpr int kSmallestRegion = 12;  // [px]

MarkerCorners cornersOf(const DecodedMarker& decoded);

/// `search: own`: outlines of dark quadrilaterals, and the codes that they show. Not thread-safe.
class OwnSearch {
 public:
  /// `ids`: markers looked for; empty: all of the family.
  OwnSearch(const MarkerFamily& family, const DetectorParameters& parameters, const std::set<int>& ids);

  /// Markers in a part of the image, corners as decoded; one that several outlines show several times.
  /// `strong_shadows`: instead, only what the edge of a shadow lies across, even of a strong one.
  std::vector<MarkerCorners> find(const ImageLevels& image, const cv::Rect& region, bool strong_shadows) const;

  /// What can be read, or better than so far, once a shadow's edge across it is taken away.
  std::optional<MarkerCorners> inShadow(const ImageLevels& image, const DecodedMarker& so_far) const;

  const MarkerDecoder& decoder() const { return decoder_; }

 private:
  std::optional<MarkerCorners> inShadow(const ImageLevels& image, const Sight& sight,
                                        const DecodedMarker* so_far) const;
  std::optional<MarkerCorners> inGlare(const ImageLevels& image, const Sight& sight) const;
  std::optional<MarkerCorners> read(const ImageLevels& image, const Quad& quad, bool strong_shadows) const;
  void addClose(const ImageLevels& image, const cv::Rect& region, const std::vector<Quad>& tried,
                std::vector<MarkerCorners>& markers) const;

  DetectorParameters parameters_;
  std::set<int> ids_;
  MarkerDecoder decoder_;
};

/// How outlines of prints are looked for that have little white before dark surroundings.
QuadSearch closeSearch(const DetectorParameters& parameters);

}  // namespace seater_perception
