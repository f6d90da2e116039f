#include "seater_perception/marker_pattern.h"

#include <string>

#include "seater_perception/errors.h"

namespace seater_perception {

MarkerPattern::MarkerPattern(int cells)
    : cells_(cells), values_(static_cast<std::size_t>((cells + 2) * (cells + 2)), 1.0) {}

MarkerPattern MarkerPattern::fromCells(const std::vector<std::vector<int>>& rows_from_top) {
  const std::size_t n = rows_from_top.size();
  if (n < 3) throw ConfigurationError("cells: " + std::to_string(n) + " rows, must be 3 or more");
  MarkerPattern pattern(static_cast<int>(n));
  for (std::size_t row = 0; row < n; ++row) {
    if (rows_from_top[row].size() != n) {
      throw ConfigurationError("cells: row " + std::to_string(row) + " has " +
                               std::to_string(rows_from_top[row].size()) + " columns, must have " + std::to_string(n));
    }
    for (std::size_t column = 0; column < n; ++column) {
      pattern.values_[(n - row) * (n + 2) + column + 1] = rows_from_top[row][column] != 0 ? 1.0 : 0.0;
    }
  }
  return pattern;
}

}  // namespace seater_perception
