#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "numerics/quad.h"
#include "search/code/glare.h"
#include "search/code/image_levels.h"
#include "search/code/pattern_template.h"
#include "search/code/shadow_edge.h"
#include "seater_perception/marker_family.h"

namespace seater_perception {

/// The marker that a quadrilateral shows.
struct DecodedMarker {
  int id = 0;
  Quad corners;              ///< top-left, top-right, bottom-right, bottom-left as the print is read [px]
  double correlation = 0.0;  ///< of the grey levels, quiet zone and border included, with the code's
  double margin = 0.0;       ///< of correlation over the next best code or orientation
  double worst_bit = 0.0;    ///< largest deviation of a cell, of what would turn its bit round
  int contradicted = 0;      ///< cells that noise has turned round
  /// -log((1 - correlation^2) worst_bit) + 5 margin: all together. What only resembles a marker has one of them at
  /// most. Each sample left out as covered counts 0.5 against it.
  double evidence = 0.0;
  double surplus = 0.0;     ///< evidence beyond what was needed
  int template_level = -1;  ///< template blur level of the fitted code: index into TemplateBook::kTemplateSd
  /// Grey level of its ink, and of its paper over that; contrast 0: a part is covered, or there is motion blur.
  double dark = 0.0, contrast = 0.0;
  bool steep = false;            ///< read with the blur of a print that is seen at a steep angle
  ImageLevels::Samples samples;  ///< under its corners; empty: something was left out
};

/// What the image shows under a quadrilateral.
struct Sight {
  Quad quad;
  ImageLevels::Samples samples;
};

/// Compares quadrilaterals with the codes of a family. Grey levels are taken at four points of each cell and in the
/// quiet zone, and correlated with every code in its four orientations; then the most likely code, blurred as by
/// the camera, is fitted to them by moving its plane (Gauss-Newton). So corners are exact to about 0.1 px, codes of
/// two pixels a cell can be told, and what is not a marker fits badly. Not thread-safe.
class MarkerDecoder {
 public:
  /// `ids`: codes that are looked for; empty: all of the family.
  MarkerDecoder(const MarkerFamily& family, const std::set<int>& ids);
  ~MarkerDecoder();
  MarkerDecoder(MarkerDecoder&&) noexcept;

  /// What is under a quadrilateral (clockwise in the image); nothing when too little of it is in the image, or it has
  /// no dark border within lighter surroundings: there is no print.
  std::optional<Sight> look(const ImageLevels& image, const Quad& quad) const;

  /// The code that is seen; nothing when there is less than
  /// `min_evidence` (of DICT_4X4_50; less for families whose codes are rarer), when another code is about as likely, or
  /// when a bit contradicts. Of a large marker, a part of border and quiet zone may be covered.
  std::optional<DecodedMarker> decode(const ImageLevels& image, const Sight& sight, double min_evidence) const;
  /// The same of a quadrilateral that has not been looked at.
  std::optional<DecodedMarker> decode(const ImageLevels& image, const Quad& quad, double min_evidence) const;

  /// The edge of a shadow across what may be a print here, as its quiet zone shows it.
  std::optional<ShadowEdge> shadowEdge(const Sight& sight) const;

  /// Glare on what may be a print here, and its id, most likely first.
  struct CodeInGlare {
    int id;
    Glare glare;
  };
  std::vector<CodeInGlare> inGlare(const Sight& sight) const;

  /// A known code whose corners are about here (in the print's order), at most `reach` [px] away (0: only what the fit
  /// itself reaches, about a third of a cell). `template_level`: of the last image, tried first; -1: not known.
  std::optional<DecodedMarker> decodeNear(int id, const ImageLevels& image, const Quad& corners, double reach,
                                          double min_evidence, int template_level = -1) const;

  int cells() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seater_perception
