#include "search/decoder/code_edges.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// The quiet zone may be nearly as dark as the ink (prints cut close): its edge tells nothing then. Chosen by hand.
constexpr double kSmallestStep = 0.3;  // of the contrast

/// The quadrilateral whose grid lies a quarter of a cell further right (`down`: down): from the first one on, every
/// other column (row) of its samples lies on an edge between cells.
Quad shifted(const Quad& quad, int cells, bool down) {
  static const Eigen::Vector2d kCorners[] = {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};
  const SquareToQuad map(quad);
  const double quarter = 0.5 / cells;
  Quad result;
  for (std::size_t i = 0; i < 4; ++i) {
    result[i] = map(kCorners[i] + quarter * (down ? Eigen::Vector2d::UnitY() : Eigen::Vector2d::UnitX()));
  }
  return result;
}

/// Deviations of grey levels on edges, and their sums.
struct Deviations {
  double count = 0.0, sum = 0.0, squares = 0.0;

  void add(double deviation) { count += 1.0, sum += deviation, squares += deviation * deviation; }
};

/// The edges square to one axis of the print.
class EdgesAcross {
 public:
  EdgesAcross(const ImageLevels& image, const TemplateBook& book, const Alignment& code, bool down)
      : grid_(book.grid()), pattern_(book.pattern(code.id)), code_(code), down_(down) {
    image.sample(shifted(code.quad, grid_.cells(), down), grid_, samples_);
  }

  /// `edge`: before this cell; `line`: of the samples beside each other along it.
  void measure(int edge, int line, Deviations& deviations) const {
    const int beside = (line - 1) / 2;
    if (white(edge - 1, beside) == white(edge, beside)) return;
    const int i = down_ ? 2 * edge * grid_.along() + line : line * grid_.along() + 2 * edge;
    const int next = i + (down_ ? grid_.along() : 1);
    const bool covered = code_.free.size() > 0 && !(code_.free[i] > 0.0f && code_.free[next] > 0.0f);
    const bool outline = edge == 0 || edge == grid_.cells();
    const double step = code_.fit.gain + (outline ? code_.fit.quiet : 0.0);
    if (covered || !(samples_.weights[i] > 0.0f) || step < kSmallestStep * code_.fit.gain) return;
    const double deviation = (static_cast<double>(samples_.grey[i]) - darkAt(edge, line)) / step - 0.5;
    deviations.add(std::clamp(deviation, -0.5, 0.5));
  }

 private:
  bool white(int along, int beside) const {
    const int last = grid_.cells() - 1;  // the pattern's rows count from the bottom
    return (down_ ? pattern_.at(beside, last - along) : pattern_.at(along, last - beside)) > 0.5;
  }
  double darkAt(int edge, int line) const {
    const double at = 2.0 * edge / grid_.cells() - 1.0;
    const auto& light = code_.fit.light;
    return down_ ? light[0] + light[1] * grid_.x(line) + light[2] * at
                 : light[0] + light[1] * at + light[2] * grid_.y(line);
  }

  const PatternGrid& grid_;
  const MarkerPattern& pattern_;
  const Alignment& code_;
  const bool down_;
  ImageLevels::Samples samples_;
};

}  // namespace

CodeEdges codeEdges(const ImageLevels& image, const TemplateBook& book, const Alignment& code) {
  const int cells = book.grid().cells(), along = book.grid().along();
  Deviations outline, bits;
  for (const bool down : {false, true}) {
    const EdgesAcross edges(image, book, code, down);
    for (int edge = 0; edge <= cells; ++edge) {
      for (int line = 1; line + 1 < along; ++line) edges.measure(edge, line, edge % cells == 0 ? outline : bits);
    }
  }
  CodeEdges result;
  if (!(bits.count > 0.0)) return result;
  const double g = result.growth = (outline.sum + bits.sum) / (outline.count + bits.count);
  result.spread = std::sqrt(std::max(0.0, (bits.squares - 2.0 * g * bits.sum) / bits.count + g * g));
  return result;
}

}  // namespace seater_perception
