#include "search/marker_detector.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "image/image_checks.h"
#include "search/opencv_search.h"
#include "search/outline/edge_fit.h"
#include "search/own_search.h"
#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

// Of a large marker, corners of the fitted code are 0.03 cells off, which may be more than `edge_band_max`. A quarter
// of a cell holds that and leaves the inner edge of the border out.
constexpr double kCoarseBand = 0.25;  // [cells] half width of the band
// As little as tells light cells from dark ones beside each other (two samples a cell: H. Nyquist, 1928).
constexpr double kPartedFrom = 2.0;  // [px] the shorter side of a cell
/// Markers on their way to a result.
struct Found {
  std::vector<MarkerCorners> markers;
  std::set<int> coarse;                 // whose corners have still to be refined
  std::vector<MarkerCorners> repeated;  // of the ids that are seen at several places, each of them
  std::set<int> doubtful;               // these ids
  std::set<int> weak;                   // whose bits need their edges as a second proof
};

const MarkerFamily& requireMarkers(const MarkerFamily& family) {
  if (family.count() == 0) throw ConfigurationError("dictionary: the marker family has no markers");
  return family;
}

/// Two outlines of the same print (its inner and outer contour) overlap: the larger one is the marker's.
void addPlace(const MarkerCorners& marker, std::vector<MarkerCorners>& places) {
  for (MarkerCorners& other : places) {
    const double larger = std::max(marker.side(), other.side());
    if ((centre(marker.corners) - centre(other.corners)).norm() > 0.5 * larger) continue;
    if (marker.side() > other.side()) other = marker;
    return;
  }
  places.push_back(marker);
}

/// One marker per id; those of ids that stand at several places are apart.
Found sorted(const std::vector<MarkerCorners>& found) {
  std::map<int, std::vector<MarkerCorners>> places;
  for (const MarkerCorners& marker : found) addPlace(marker, places[marker.id]);
  Found result;
  for (const auto& [id, markers] : places) {
    auto& kind = markers.size() == 1 ? result.markers : result.repeated;
    kind.insert(kind.end(), markers.begin(), markers.end());
    if (markers.size() > 1) result.doubtful.insert(id);
  }
  return result;
}

}  // namespace

struct MarkerDetector::Implementation {
  MarkerFamily family;
  DetectorParameters parameters;
  OwnSearch own;
  OpenCvSearch opencv;

  Found search(const ImageLevels& image, bool strong_shadows) const;
  void searchNear(const ImageLevels& image, const std::vector<ExpectedMarker>& expected, Found& found) const;
  SearchResult finish(const cv::Mat& grey, Found& found) const;
  std::optional<MarkerCorners> outlineNear(const ImageLevels& image, const ExpectedMarker& expected) const;
  std::optional<FittedEdges> edges(const cv::Mat& grey, const MarkerCorners& marker) const;
  void refine(const cv::Mat& grey, MarkerCorners& marker) const;
  bool chosen(const MarkerCorners& marker) const;
};

/// All of the image.
Found MarkerDetector::Implementation::search(const ImageLevels& image, bool strong_shadows) const {
  if (parameters.search != "own") return sorted(opencv.find(image.grey()));
  const cv::Rect all(0, 0, image.grey().cols, image.grey().rows);
  std::vector<MarkerCorners> found = own.find(image, all, false);
  if (found.empty() && strong_shadows) found = own.find(image, all, true);
  return sorted(found);
}

/// Whether the fit had a choice that may make a code out of what is none: samples left out as covered, or a blur as of
/// a steep angle where pixels hardly part the bits. Without four edges, the bits then have to prove more.
bool MarkerDetector::Implementation::chosen(const MarkerCorners& marker) const {
  const bool covered = !(marker.contrast > 0.0);
  return covered || (marker.steep && shortestSide(marker.corners) < kPartedFrom * family.cells());
}

/// The edges of a marker; from corners that are only good to a part of a cell, those of a large one in two steps.
std::optional<FittedEdges> MarkerDetector::Implementation::edges(const cv::Mat& grey,
                                                                 const MarkerCorners& marker) const {
  const DetectorParameters& p = parameters;
  const double cell = shortestSide(marker.corners) / family.cells();
  const double band = std::clamp(p.edge_band * cell, p.edge_band_min, p.edge_band_max);
  const auto narrow = fitEdges(grey, marker.corners, band);
  if (narrow || kCoarseBand * cell < band) return narrow;
  const auto wide = fitEdges(grey, marker.corners, kCoarseBand * cell);
  return wide ? fitEdges(grey, wide->corners, band) : std::nullopt;
}

void MarkerDetector::Implementation::refine(const cv::Mat& grey, MarkerCorners& marker) const {
  // OpenCV's outlines follow the steps of pixels; the own search has already fitted the code.
  if (parameters.search != "own") refineSubPixel(grey, family.cells(), parameters, marker);
  if (!parameters.edge_fit) return;
  if (const auto fitted = edges(grey, marker)) {
    marker.corners = fitted->corners;
    marker.edges_fitted = true;
    marker.psf_sd = fitted->psf_sd;
    marker.edge_residual = fitted->residual;
  }
}

/// The marker by its outline, in the part of the image that it should be in.
std::optional<MarkerCorners> MarkerDetector::Implementation::outlineNear(const ImageLevels& image,
                                                                         const ExpectedMarker& expected) const {
  const Eigen::Vector2d low = boundingBox(expected.corners).min(), high = boundingBox(expected.corners).max();
  const double margin = expected.reach + 0.2 * (high - low).maxCoeff() + 3.0;  // the quiet zone and the smoothing too
  const auto whole = [](double x, double limit) { return static_cast<int>(std::clamp(x, 0.0, limit)); };
  const int width = image.grey().cols, height = image.grey().rows;
  const cv::Point first(whole(low.x() - margin, width), whole(low.y() - margin, height));
  const cv::Point last(whole(high.x() + margin + 1.0, width), whole(high.y() + margin + 1.0, height));
  const cv::Rect region(first, last);
  if (region.width < kSmallestRegion || region.height < kSmallestRegion) return std::nullopt;
  for (const bool strong_shadows : {false, true}) {
    for (const MarkerCorners& marker : sorted(own.find(image, region, strong_shadows)).markers) {
      if (marker.id == expected.id) return marker;
    }
  }
  return std::nullopt;
}

void MarkerDetector::Implementation::searchNear(const ImageLevels& image, const std::vector<ExpectedMarker>& expected,
                                                Found& found) const {
  for (const ExpectedMarker& e : expected) {
    const auto decoded = own.decoder().decodeNear(e.id, image, e.corners, e.reach, e.min_evidence, e.template_level);
    std::optional<MarkerCorners> marker;
    if (decoded) marker = own.inShadow(image, *decoded);
    if (!marker && decoded)
      marker = cornersOf(*decoded);
    else if (!marker && e.by_outline)
      marker = outlineNear(image, e);
    if (!marker) continue;
    if (e.edges || !decoded || !(decoded->contrast > 0.0)) found.coarse.insert(marker->id);
    found.markers.push_back(*marker);
  }
}

/// Takes the shadows away, once for all markers, and refines corners in that image.
SearchResult MarkerDetector::Implementation::finish(const cv::Mat& grey, Found& found) const {
  std::vector<ShadowEdge> shadows;
  std::vector<Glare> glares;
  for (const MarkerCorners& marker : found.markers) {
    if (marker.shadow) shadows.push_back(*marker.shadow);
    if (marker.glare) glares.push_back(*marker.glare);
  }
  SearchResult result;
  result.lit = withoutGlare(withoutShadows(grey, shadows), glares);
  result.doubtful = found.doubtful;
  result.repeated = found.repeated;
  result.markers = found.markers;
  std::sort(result.markers.begin(), result.markers.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  for (MarkerCorners& marker : result.markers) {
    if (found.coarse.count(marker.id)) refine(result.lit, marker);
  }
  for (MarkerCorners& marker : result.repeated) refine(result.lit, marker);
  const auto unproved = [&found](const MarkerCorners& m) { return !m.edges_fitted && found.weak.count(m.id) > 0; };
  const bool own = parameters.search == "own" && parameters.edge_fit;
  auto& markers = result.markers;
  if (own) markers.erase(std::remove_if(markers.begin(), markers.end(), unproved), markers.end());
  return result;
}

MarkerDetector::MarkerDetector(const MarkerFamily& family, const DetectorParameters& parameters,
                               const std::set<int>& ids)
    : implementation_(new Implementation{requireMarkers(family), parameters, OwnSearch(family, parameters, ids),
                                         OpenCvSearch(family, ids, parameters)}) {}

MarkerDetector::~MarkerDetector() = default;
MarkerDetector::MarkerDetector(MarkerDetector&&) noexcept = default;

SearchResult MarkerDetector::detect(const cv::Mat& grey, const std::vector<ExpectedMarker>& expected,
                                    bool strong_shadows) const {
  checkImage(grey);
  const ImageLevels image(grey);
  Found found = implementation_->search(image, strong_shadows);
  for (const MarkerCorners& marker : found.markers) {
    found.coarse.insert(marker.id);
    if (marker.surplus < kDecades && implementation_->chosen(marker)) found.weak.insert(marker.id);
  }
  std::vector<ExpectedMarker> missing;
  for (const ExpectedMarker& e : expected) {
    if (!found.coarse.count(e.id) && !found.doubtful.count(e.id)) missing.push_back(e);
  }
  implementation_->searchNear(image, missing, found);
  return implementation_->finish(grey, found);
}

SearchResult MarkerDetector::searchNear(const cv::Mat& grey, const std::vector<ExpectedMarker>& expected) const {
  checkImage(grey);
  Found found;
  implementation_->searchNear(ImageLevels(grey), expected, found);
  return implementation_->finish(grey, found);
}

int MarkerDetector::cells() const {
  return implementation_->own.decoder().cells();
}

void MarkerDetector::refine(const cv::Mat& grey, MarkerCorners& marker) const {
  implementation_->refine(grey, marker);
}

}  // namespace seater_perception
