#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "seater_perception/quad_search.h"

namespace seater_perception {

/// What a quadrilateral shows.
struct PatternReading {
  int id = 0;
  Quad corners;              ///< top-left, top-right, bottom-right, bottom-left as the print is read [px]
  double correlation = 0.0;  ///< of its cells' grey levels, quiet zone and border included, with the code's
};

/// Compares quadrilaterals with the codes of a dictionary: grey levels are taken at the middles of all cells and of the
/// quiet zone round them and correlated with every code in its four orientations, blurred as a camera would at that
/// size. No bit is decided alone, so codes of two pixels a cell can be told; but every bit has to be on its side.
class PatternReader {
 public:
  /// `ids`: codes that are looked for; empty: all of the dictionary. Throws ConfigurationError.
  PatternReader(const std::string& dictionary, const std::set<int>& ids);

  /// The code that a quadrilateral (clockwise in the picture) shows; nothing when the best correlation is smaller than
  /// `min_correlation`, when another code is about as likely, or when a bit contradicts. Corners are adjusted by up to
  /// some pixels, to where the correlation is largest. `grey` is CV_8UC1.
  std::optional<PatternReading> read(const cv::Mat& grey, const Quad& quad, double min_correlation) const;

  /// A known code whose corners are about here (in the print's order), at most `reach` [px] away.
  std::optional<PatternReading> follow(int id, const cv::Mat& grey, const Quad& corners, double reach,
                                       double min_correlation) const;

  int cells() const { return cells_; }

 private:
  static constexpr int kBlurs = 3;
  struct Code {
    int id = 0, turn = 0;
    std::array<std::vector<float>, kBlurs> values;  // zero mean, unit length
    std::vector<char> bits;                         // 1 white, of all cells and the quiet zone
  };
  struct Samples {
    std::vector<float> grey;  // row by row from the top
    std::vector<char> seen;   // 0: outside the picture
    int count = 0;
  };

  bool sample(const cv::Mat& grey, const Quad& quad, Samples& samples) const;
  double correlate(const Samples& samples, const std::vector<float>& code) const;
  bool hasBorder(const Samples& samples) const;
  bool everyBit(const Samples& samples, const Code& code, int blur) const;
  double adjust(const cv::Mat& grey, const Code& code, int blur, double start, Quad& quad, Samples& samples) const;
  int blurFor(const Quad& quad) const;

  int cells_ = 0, side_ = 0;  // along a side; side_ with the quiet zone
  std::vector<Code> codes_;
};

}  // namespace seater_perception
