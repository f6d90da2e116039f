// A second proof of a code: do the edges between its bits lie where it has them?
#pragma once

#include "search/code/pattern_alignment.h"

namespace seater_perception {

/// Grey levels on the edges between dark and white cells, which a code's own samples, a quarter of a cell beside them,
/// hardly see. Where an edge lies in its place, that is halfway between dark and white, whatever the blur.
struct CodeEdges {
  double growth = 0.0;  ///< mean deviation of all edges towards white, of the step from dark to white: -0.5 .. 0.5
  double spread = 0.0;  ///< root mean square deviation from that of the edges within the border: 0 .. 1
};

/// Of a fitted code; edges beside what `code` leaves out as covered, and what is out of the image, do not count.
CodeEdges codeEdges(const ImageLevels& image, const TemplateBook& book, const Alignment& code);

}  // namespace seater_perception
