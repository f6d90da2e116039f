#include "search/own_search.h"

#include <algorithm>

#include "search/outline/quad_search.h"

namespace seater_perception {
namespace {

// With a wider threshold window, the edge of a strong shadow grows together with the print's border. Chosen by hand,
// with perception_shadows.
constexpr int kNarrowWindow = 7;  // [px]
// White of half a pixel's width still parts a print from what is dark beside it. Without smoothing, noise has to stay
// below the constant. Chosen with drawn prints (docs/results/photographs.md, Little white): windows of 3 to 7 px
// find as many within 10 %, smoothed ones two thirds.
constexpr int kCloseWindow = 5;         // [px]
constexpr double kCloseConstant = 7.0;  // [grey levels]

constexpr double kCostOfGlare = 1.2;  // evidence

std::set<int> idsOf(const std::vector<MarkerCorners>& markers) {
  std::set<int> ids;
  for (const MarkerCorners& marker : markers) ids.insert(marker.id);
  return ids;
}

/// Outlines of a part of the image, in coordinates of the whole. `known`: markers at which none is looked for.
std::vector<Quad> quadsIn(const cv::Mat& grey, const cv::Rect& region, const QuadSearch& search,
                          const std::vector<MarkerCorners>& known = {}) {
  const Eigen::Vector2d origin(region.x, region.y);
  std::vector<Quad> places;
  for (const MarkerCorners& marker : known) {
    places.push_back(marker.corners);
    for (auto& corner : places.back()) corner -= origin;
  }
  std::vector<Quad> quads = findQuads(grey(region), search, places);
  for (Quad& quad : quads) {
    for (auto& corner : quad) corner += origin;
  }
  return quads;
}

}  // namespace

MarkerCorners cornersOf(const DecodedMarker& decoded) {
  MarkerCorners marker;
  marker.id = decoded.id;
  marker.corners = decoded.corners;
  marker.surplus = decoded.surplus;
  marker.template_level = decoded.template_level;
  marker.dark = decoded.dark;
  marker.contrast = decoded.contrast;
  marker.steep = decoded.steep;
  return marker;
}

QuadSearch closeSearch(const DetectorParameters& parameters) {
  QuadSearch search;
  search.window = kCloseWindow;
  search.constant = std::max(kCloseConstant, parameters.search_constant);
  search.min_side = parameters.min_side;
  search.smooth = false;
  search.faint = true;
  return search;
}

OwnSearch::OwnSearch(const MarkerFamily& family, const DetectorParameters& parameters, const std::set<int>& ids)
    : parameters_(parameters), ids_(ids), decoder_(family, ids) {}

/// The marker that an outline may be of. `strong_shadows`: only what the edge of a shadow lies across, even of a strong
/// one.
std::optional<MarkerCorners> OwnSearch::read(const ImageLevels& image, const Quad& quad, bool strong_shadows) const {
  const auto sight = decoder_.look(image, quad);
  if (!sight) return std::nullopt;
  std::optional<DecodedMarker> decoded;
  if (!strong_shadows) decoded = decoder_.decode(image, *sight, parameters_.min_evidence);
  std::optional<MarkerCorners> marker = decoded ? inShadow(image, *decoded) : inShadow(image, *sight, nullptr);
  // What a strong shadow's edge crosses may be read so badly that its corners no longer show the shadow.
  if (!marker && decoded && decoded->surplus < kDecades) marker = inShadow(image, *sight, &*decoded);
  if (!marker && decoded) marker = cornersOf(*decoded);
  if (!marker && !strong_shadows) marker = inGlare(image, *sight);
  return marker;
}

/// `strong_shadows`: instead, only what the edge of a shadow lies across.
std::vector<MarkerCorners> OwnSearch::find(const ImageLevels& image, const cv::Rect& region,
                                           bool strong_shadows) const {
  QuadSearch search;
  search.window = (strong_shadows ? kNarrowWindow : parameters_.search_window) | 1;
  search.constant = parameters_.search_constant;
  search.min_side = parameters_.min_side;
  std::vector<MarkerCorners> markers;
  const std::vector<Quad> quads = quadsIn(image.grey(), region, search);
  for (const Quad& quad : quads) {
    const auto marker = read(image, quad, strong_shadows);
    if (marker && marker->side() >= parameters_.min_side) markers.push_back(*marker);
  }
  if (!strong_shadows && (ids_.empty() || idsOf(markers).size() < ids_.size())) addClose(image, region, quads, markers);
  return markers;
}

/// Prints with little white round them before dark surroundings, in part in a shadow, or on paper darker than the wall:
/// there, smoothing and a wide window make one outline of the print and what lies round it. `tried`: outlines that have
/// been read.
void OwnSearch::addClose(const ImageLevels& image, const cv::Rect& region, const std::vector<Quad>& tried,
                         std::vector<MarkerCorners>& markers) const {
  const std::size_t before = markers.size();
  for (const Quad& quad : quadsIn(image.grey(), region, closeSearch(parameters_), markers)) {
    const auto same = [&quad](const Quad& other) { return sameOutline(quad, other); };
    const auto within = [&quad](const MarkerCorners& m) {
      return (centre(quad) - centre(m.corners)).norm() < 0.5 * m.side() && meanSide(quad) < 1.1 * m.side();
    };
    const auto end = markers.begin() + static_cast<std::ptrdiff_t>(before);
    if (std::any_of(markers.begin(), end, within) || std::any_of(tried.begin(), tried.end(), same)) continue;
    const auto marker = read(image, quad, false);
    if (marker && marker->side() >= parameters_.min_side) markers.push_back(*marker);
  }
}

/// What can be read once a lamp's mirror image on it is taken away.
std::optional<MarkerCorners> OwnSearch::inGlare(const ImageLevels& image, const Sight& sight) const {
  for (const auto& code : decoder_.inGlare(sight)) {
    const cv::Rect part = code.glare.region & cv::Rect(0, 0, image.grey().cols, image.grey().rows);
    if (part.width < kSmallestRegion || part.height < kSmallestRegion) continue;
    const Eigen::Vector2d origin(part.x, part.y);
    const cv::Mat lit = withoutGlare(image.grey()(part), {code.glare.seenFrom(origin)});
    Quad there = sight.quad;
    for (auto& corner : there) corner -= origin;
    auto decoded = decoder_.decode(ImageLevels(lit), there, parameters_.min_evidence + kCostOfGlare);
    if (!decoded || decoded->id != code.id) continue;
    for (auto& corner : decoded->corners) corner += origin;
    MarkerCorners marker = cornersOf(*decoded);
    marker.glare = code.glare;
    return marker;
  }
  return std::nullopt;
}

std::optional<MarkerCorners> OwnSearch::inShadow(const ImageLevels& image, const DecodedMarker& so_far) const {
  if (so_far.samples.grey.size() > 0) return inShadow(image, {so_far.corners, so_far.samples}, &so_far);
  const auto sight = decoder_.look(image, so_far.corners);
  return sight ? inShadow(image, *sight, &so_far) : std::nullopt;
}

std::optional<MarkerCorners> OwnSearch::inShadow(const ImageLevels& image, const Sight& sight,
                                                 const DecodedMarker* so_far) const {
  const auto shadow = decoder_.shadowEdge(sight);
  if (!shadow) return std::nullopt;
  const cv::Rect part = shadow->region & cv::Rect(0, 0, image.grey().cols, image.grey().rows);
  if (part.width < kSmallestRegion || part.height < kSmallestRegion) return std::nullopt;
  const Eigen::Vector2d origin(part.x, part.y);
  const cv::Mat lit = withoutShadows(image.grey()(part), {shadow->seenFrom(origin)});
  Quad there = sight.quad;
  for (auto& corner : there) corner -= origin;
  auto decoded = decoder_.decode(ImageLevels(lit), there, parameters_.min_evidence);
  if (!decoded || (so_far && (decoded->id != so_far->id || decoded->evidence < so_far->evidence))) return std::nullopt;
  for (auto& corner : decoded->corners) corner += origin;
  MarkerCorners marker = cornersOf(*decoded);
  marker.shadow = shadow;
  return marker;
}

}  // namespace seater_perception
