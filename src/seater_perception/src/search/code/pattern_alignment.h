#pragma once

#include <memory>
#include <optional>

#include "search/code/image_levels.h"
#include "search/code/template_book.h"

namespace seater_perception {

/// A code on its way to the image.
struct Alignment {
  /// 0.36 cells: wide enough to pull from a third of a cell away.
  static constexpr int kStartLevel = 6;

  int id = 0;
  int level = kStartLevel;       ///< template blur level: index into TemplateBook::kTemplateSd
  Quad quad;                     ///< in the print's order [px]
  ImageLevels::Samples samples;  ///< under it; empty: not looked at yet
  PatternTemplate::Fit fit;
  std::shared_ptr<const PatternTemplate> own;  ///< in place of the book's: image moved, or print seen at a steep angle
  bool moved = false;                          ///< of an image that moved
  double own_sd = 0.0;                         ///< of `own`: geometric mean of the widths of its PSF [cells]
  Eigen::VectorXf free;                        ///< 0 where something covers the print; empty: nothing does

  /// Number of samples that are left out.
  double covered() const { return free.size() == 0 ? 0.0 : static_cast<double>(free.size()) - free.sum(); }
  const Eigen::VectorXf* weights() const { return samples.all() && free.size() == 0 ? nullptr : &samples.weights; }
};

/// Cells that are not as their code has them.
struct BitErrors {
  double worst = 0.0;    ///< largest deviation
  int contradicted = 0;  ///< cells with kLargest and more

  /// From there on, a cell speaks for the opposite bit: noise may have turned it.
  static constexpr double kLargest = 0.9;
};

/// Moves a known code's corners to where it explains most of the image (Gauss-Newton), and chooses the template blur
/// level.
class PatternAligner {
 public:
  /// Part explained, below which a fit is given up. Chosen by hand, far below what a marker explains in the end.
  static constexpr double kHopeless = 0.2;

  explicit PatternAligner(const TemplateBook& book) : book_(book) {}

  /// Samples the image under the quadrilateral; false when too little of it is in the image.
  bool look(const ImageLevels& image, Alignment& a) const;
  /// Dark border, lighter quiet zone: what nearly everything that is no marker lacks.
  bool hasBorder(const ImageLevels::Samples& samples) const;
  /// Something light within the border: dark patches, which are most of what has a border, do not.
  bool showsBits(const ImageLevels::Samples& samples) const;
  /// From corners within about a third of a cell. False, and `a` of no use, when it is not there. `least`: part
  /// explained by a rough fit, below which it is given up.
  bool align(const ImageLevels& image, Alignment& a, double least = 0.0) const;
  /// The same for an image that moved by up to about 8 px during its exposure, in whatever direction.
  bool alignMotionBlurred(const ImageLevels& image, Alignment& a) const;
  /// The same for a print seen at a steep angle: what is round in the image is a long ellipse in cells. False, too,
  /// when the angle is not steep.
  bool alignSteep(const ImageLevels& image, Alignment& a) const;
  /// How far cells' means deviate from the code, of what would turn a bit round: above 1, it reads as its opposite.
  BitErrors bitErrors(const Alignment& a) const;
  /// Marks samples of border and quiet zone that deviate; false when nothing or too much does, or the marker is small.
  bool leaveOutCovered(Alignment& a) const;

 private:
  const PatternTemplate& templateOf(const Alignment& a) const;
  bool descend(const ImageLevels& image, double done, Alignment& a) const;
  bool chooseLevel(Alignment& a) const;
  /// The best fit of a template blurred so in the image [px^2], from the quadrilateral of `a`.
  std::optional<Alignment> alignBlurred(const ImageLevels& image, const Alignment& a,
                                        const Eigen::Matrix2d& spread) const;

  const TemplateBook& book_;
};

}  // namespace seater_perception
