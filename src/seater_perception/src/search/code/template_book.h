#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "search/code/image_levels.h"
#include "search/code/pattern_template.h"
#include "seater_perception/marker_family.h"

namespace seater_perception {

/// The codes looked for, as templates blurred by several point spread functions (levels); made when they are needed.
/// Not thread-safe.
class TemplateBook {
 public:
  static constexpr std::array<double, 11> kTemplateSd{0.12, 0.145, 0.175, 0.21, 0.25, 0.3,
                                                      0.36, 0.43,  0.52,  0.62, 0.75};  // [cells] standard deviation

  /// `ids`: empty: all of the family.
  TemplateBook(const MarkerFamily& family, const std::set<int>& ids);

  const PatternGrid& grid() const { return grid_; }
  const MarkerPattern& pattern(int id) const;
  bool has(int id) const { return std::binary_search(ids_.begin(), ids_.end(), id); }
  const PatternTemplate& of(int id, int level) const;

  /// A code in one of four orientations; `turn`: number of the print's corner that is the quadrilateral's first.
  struct Candidate {
    int id = 0, turn = 0;
    double correlation = 0.0;
  };
  /// All codes in all orientations, correlated with samples (slopes of the light taken off); best first, `count` at
  /// most. What was not seen counts as if it were a plane of light.
  std::vector<Candidate> compare(const ImageLevels::Samples& samples, int level, std::size_t count) const;

 private:
  /// What a level's point spread function makes of the codes.
  struct Blurred {
    Eigen::MatrixXf shares;    ///< of each cell (column) in the grid's points (row) along one axis
    Eigen::VectorXf unlength;  ///< one over each code's length, slopes of the light taken off; `ink_`'s rows
  };
  const Blurred& blurred(int level) const;
  const RoundBlur& round(int level) const;
  Eigen::VectorXf lengths(const Eigen::MatrixXf& shares) const;
  Eigen::VectorXf restOf(const ImageLevels::Samples& samples) const;

  MarkerFamily family_;
  std::vector<int> ids_;  // that are looked for, ascending
  PatternGrid grid_;
  int border_;
  // A row for each id, as many more as make whole blocks, a column for each cell within the border (row by row from the
  // top): -1 where it is black, else 0.
  Eigen::MatrixXf ink_;
  mutable std::map<int, MarkerPattern> patterns_;
  mutable std::map<std::pair<int, int>, std::unique_ptr<PatternTemplate>> templates_;
  mutable std::array<Blurred, kTemplateSd.size()> blurred_;
  mutable std::array<std::optional<RoundBlur>, kTemplateSd.size()> round_;
  Eigen::Matrix<float, Eigen::Dynamic, 3> light_;  // orthonormal: offset and slopes
};

}  // namespace seater_perception
