#include "pipeline/family_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

/// The first codes of `larger` are those of `smaller`.
bool begins(const MarkerFamily& smaller, const MarkerFamily& larger) {
  const bool same_print = smaller.bits() == larger.bits() && smaller.border() == larger.border();
  if (!same_print || smaller.count() > larger.count()) return false;
  for (int id = 0; id < smaller.count(); ++id) {
    if (smaller.code(id) != larger.code(id)) return false;
  }
  return true;
}

/// `left_out`: what is wrong with files that are no families, which other programs' files in the same folder are not.
std::vector<MarkerFamily> known(std::vector<std::string>& left_out) {
  std::vector<MarkerFamily> families;
  for (const std::string& name : MarkerFamily::names()) {
    try {
      families.push_back(MarkerFamily::named(name));
    } catch (const ConfigurationError& error) {
      left_out.push_back(error.what());
    }
  }
  return families;
}

/// The smallest family that begins this one and holds all ids of the markers.
MarkerFamily smallest(MarkerFamily family, const std::vector<PlainMarker>& markers) {
  const int highest = markers.empty() ? 0 : markers.back().id;
  std::vector<std::string> left_out;
  for (const MarkerFamily& other : known(left_out)) {
    if (other.count() > highest && other.count() < family.count() && begins(other, family)) family = other;
  }
  return family;
}

/// How much rarer than one in two a pattern is that is a code by chance, in bits.
double rarity(const MarkerFamily& family) {
  return family.bits() * family.bits() - std::log2(4.0 * family.count());
}

Eigen::Vector2d centreOf(const PlainMarker& marker) {
  return 0.25 * (marker.corners[0] + marker.corners[1] + marker.corners[2] + marker.corners[3]);
}

bool samePlace(const PlainMarker& a, const PlainMarker& b) {
  const double side = std::max((a.corners[0] - a.corners[1]).norm(), (b.corners[0] - b.corners[1]).norm());
  return (centreOf(a) - centreOf(b)).norm() < 0.5 * side;
}

std::vector<PlainMarker> plain(const SearchResult& found) {
  std::vector<PlainMarker> markers;
  for (const auto* list : {&found.markers, &found.repeated}) {
    for (const MarkerCorners& marker : *list) markers.push_back({marker.id, marker.corners});
  }
  std::stable_sort(markers.begin(), markers.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return markers;
}

std::string reasonOf(const JudgedOutline& outline, const DetectorParameters& parameters) {
  char text[160] = "no code of the dictionary shows";
  if (outline.id && outline.side < parameters.min_side) {
    std::snprintf(text, sizeof(text), "its side of %.1f px is below detector/min_side, %.1f px", outline.side,
                  parameters.min_side);
  } else if (outline.id && !outline.decoded) {
    std::snprintf(text, sizeof(text), "the evidence of its code, %.1f, is too small (detector/min_evidence %.1f)",
                  outline.evidence, parameters.min_evidence);
  } else if (outline.id) {
    std::snprintf(text, sizeof(text), "its code shows, but its edges do not confirm it");
  }
  return text;
}

/// Inner outlines of a print, and its white cells' neighbours, are no candidates of their own.
bool isWithin(const Quad& corners, const std::vector<PlainMarker>& markers) {
  const PlainMarker candidate{0, corners};
  return std::any_of(markers.begin(), markers.end(), [&](const PlainMarker& m) {
    const double half = 0.5 * std::max((m.corners[0] - m.corners[2]).norm(), (m.corners[1] - m.corners[3]).norm());
    return (centreOf(m) - centreOf(candidate)).norm() < half;
  });
}

}  // namespace

std::vector<MarkerFamily> allFamilies(std::vector<std::string>& left_out) {
  const std::vector<MarkerFamily> families = known(left_out);
  std::vector<MarkerFamily> largest;
  for (std::size_t i = 0; i < families.size(); ++i) {
    bool part = false;  // of a larger one, or of an equal one before it
    for (std::size_t k = 0; k < families.size() && !part; ++k) {
      part = k != i && begins(families[i], families[k]) && (k < i || families[k].count() > families[i].count());
    }
    if (!part) largest.push_back(families[i]);
  }
  return largest;
}

FamilySearch::FamilySearch(const std::vector<MarkerFamily>& families, const DetectorParameters& parameters)
    : parameters_(parameters), families_(families), judge_(families.front(), parameters) {
  for (const MarkerFamily& family : families) detectors_.emplace_back(family, parameters);
}

std::vector<FamilyMarkers> FamilySearch::detect(const cv::Mat& grey) const {
  std::vector<FamilyMarkers> found;
  for (std::size_t i = 0; i < families_.size(); ++i) {
    found.push_back({families_[i], plain(detectors_[i].detect(grey))});
  }
  std::stable_sort(found.begin(), found.end(), [](const FamilyMarkers& a, const FamilyMarkers& b) {
    if (a.markers.size() != b.markers.size()) return a.markers.size() > b.markers.size();
    return rarity(a.family) > rarity(b.family);
  });
  std::vector<FamilyMarkers> kept;
  for (FamilyMarkers& candidate : found) {
    std::vector<PlainMarker> left;
    for (const PlainMarker& marker : candidate.markers) {
      bool taken = false;
      for (const FamilyMarkers& other : kept) {
        taken = taken || std::any_of(other.markers.begin(), other.markers.end(),
                                     [&](const PlainMarker& m) { return samePlace(m, marker); });
      }
      if (!taken) left.push_back(marker);
    }
    if (!left.empty()) kept.push_back({smallest(candidate.family, left), left});
  }
  return kept;
}

std::vector<RefusedCandidate> FamilySearch::refusals(const cv::Mat& grey, const std::vector<PlainMarker>& found) const {
  std::vector<RefusedCandidate> refused;
  for (const JudgedOutline& outline : judge_.judge(grey)) {
    if (isWithin(outline.corners, found)) continue;
    refused.push_back({outline.corners, outline.id, reasonOf(outline, parameters_)});
  }
  return refused;
}

}  // namespace seater_perception
