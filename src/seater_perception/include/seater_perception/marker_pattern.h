#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace seater_perception {

/// The image of one printed marker as cells: border and bits, black or white. Beyond it lies the white quiet zone.
///
/// Columns count from the left, rows from the bottom as the print is read, so that column and row grow with the marker
/// frame's x and y (dock_layout.h). Cell (0, 0) is the lower left one of the black border.
class MarkerPattern {
 public:
  /// From cells given row by row from the top, 1 white, 0 black. Throws ConfigurationError when they are not a square
  /// of 3 x 3 or more.
  static MarkerPattern fromCells(const std::vector<std::vector<int>>& rows_from_top);

  /// Cells along a side, the black border included.
  int cells() const { return cells_; }
  /// 1 white, 0 black. Every cell outside 0..cells()-1 is quiet zone, white; columns and rows from -1 to cells() only.
  double at(int column, int row) const {
    return values_[static_cast<std::size_t>((row + 1) * (cells_ + 2) + column + 1)];
  }

 private:
  explicit MarkerPattern(int cells);

  int cells_;
  std::vector<double> values_;  // with a ring of quiet zone round it, row by row from the bottom
};

/// One print and where it sits on the object whose pose is wanted.
struct PatternPlacement {
  MarkerPattern pattern;
  double size = 0.0;  ///< side of the black square [m]
  Eigen::Isometry3d T_object_marker = Eigen::Isometry3d::Identity();
};

/// How bright an image shows a print: grey level = (offset + gain * white - rim * outside) * (1 + slope . p), with
/// white 0 or 1, p from -1 to 1 across the marker's box in the image, and outside the fraction of what a pixel sees
/// beyond the quiet zone.
struct Brightness {
  bool used = false;                ///< false: the marker is not in the image
  double offset = 0.0, gain = 0.0;  ///< [grey levels]
  double slope_u = 0.0, slope_v = 0.0;
  double rim = 0.0;  ///< how much darker than the paper it is beyond the quiet zone [grey levels]
};

}  // namespace seater_perception
