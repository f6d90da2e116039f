#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "numerics/quad.h"
#include "search/code/glare.h"
#include "search/code/shadow_edge.h"
#include "seater_perception/marker_family.h"
#include "seater_perception/parameters.h"

namespace seater_perception {

/// A marker in the image.
struct MarkerCorners {
  int id = 0;
  /// [px] in the image as given (not undistorted), top-left, top-right, bottom-right, bottom-left as the print is
  /// read.
  Quad corners;
  /// True: corners are intersections of fitted edges; false: of the code or cornerSubPix, less accurate.
  bool edges_fitted = false;
  double corner_sigma = 0.0;          ///< standard deviation of a corner coordinate; 0: as the parameters say [px]
  double psf_sd = 0.0;                ///< of the lens' PSF, from fitted edges or grey levels; 0: not known [px]
  double edge_residual = 0.0;         ///< as of FittedEdges [grey levels]
  double surplus = 0.0;               ///< as of DecodedMarker
  int template_level = -1;            ///< DecodedMarker::template_level; -1: not known
  double dark = 0.0, contrast = 0.0;  ///< as of DecodedMarker; contrast 0: not to be relied on
  bool steep = false;                 ///< as of DecodedMarker
  std::optional<ShadowEdge> shadow;   ///< that lies across it: corners and levels are of withoutShadows

  std::optional<Glare> glare;  ///< on it: corners and levels are of withoutGlare

  double side() const { return meanSide(corners); }  ///< mean side [px]
};

/// Where a marker should be in the image.
struct ExpectedMarker {
  int id = 0;
  Quad corners;               ///< as of MarkerCorners [px]
  double reach = 0.0;         ///< how far away it is looked for [px]; 0: only there
  double min_evidence = 0.0;  ///< how well the grey levels have to fit its code
  bool by_outline = true;     ///< and by its outline, when its code does not show there
  int template_level = -1;    ///< as of MarkerCorners in the last image; -1: not known
  bool edges = true;          ///< false: no edges are fitted where the code shows clearly
};

/// What a search finds in an image.
struct SearchResult {
  std::vector<MarkerCorners> markers;  ///< ascending id
  /// The image without the shadows across these markers, from which grey levels are to be taken; where there is no
  /// shadow, the image itself (memory is shared).
  cv::Mat lit;
  std::set<int> doubtful;               ///< ids that stand at two places: left out, nothing tells which one is meant
  std::vector<MarkerCorners> repeated;  ///< these, at all their places; ascending id
};

/// Finds markers of one family and refines their corners. Outlines and ids come from findQuads and MarkerDecoder
/// (`search: own`) or from OpenCV's detectMarkers (`opencv`). Corners: fitEdges where it succeeds; else those of the
/// fitted code (own), or cornerSubPix with a window that follows each marker's size, so that it never reaches the next
/// cell of the print (opencv).
///
/// One per thread, although its members are const: searches fill a store of templates. Results do not depend on earlier
/// calls.
class MarkerDetector {
 public:
  /// `ids`: markers looked for; empty: all of the family. Throws ConfigurationError for a family without markers.
  MarkerDetector(const MarkerFamily& family, const DetectorParameters& parameters, const std::set<int>& ids = {});
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;

  /// Searches the whole image, then looks for those `expected` markers that this has not shown, as searchNear does.
  /// `strong_shadows`: where nothing is found, markers across the edge of a strong shadow are looked for, which takes
  /// once more the time. `grey` is CV_8UC1. Throws ImageError.
  SearchResult detect(const cv::Mat& grey, const std::vector<ExpectedMarker>& expected = {},
                      bool strong_shadows = true) const;

  /// Markers near the places where they are expected: first there, then up to `reach` away, by their code, then
  /// (`by_outline`) by their outline. The evidence has to be at least `min_evidence`, every bit of the code on its
  /// side, and no other code as likely. What is not there is left out. Throws ImageError.
  SearchResult searchNear(const cv::Mat& grey, const std::vector<ExpectedMarker>& expected) const;

  int cells() const;  ///< along a marker's side, border included

  /// Refines a found marker's corners, as `detect` does; `grey`: SearchResult::lit.
  void refine(const cv::Mat& grey, MarkerCorners& marker) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seater_perception
