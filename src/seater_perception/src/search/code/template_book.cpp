#include "search/code/template_book.h"

#include <algorithm>
#include <cmath>

#include "numerics/column_products.h"
#include "numerics/normal.h"
#include "numerics/solve.h"

namespace seater_perception {
namespace {

std::map<int, MarkerPattern> patternsOf(const MarkerFamily& family, const std::set<int>& ids) {
  std::map<int, MarkerPattern> patterns;
  for (int id = 0; id < family.count(); ++id) {
    // A dock may name what its family does not have: that is never found.
    if (ids.empty() || ids.count(id)) patterns.emplace(id, family.pattern(id));
  }
  return patterns;
}

/// What the cells of a quadrilateral show (row by row), as those of the print would stand upright in it.
Eigen::VectorXf turned(const Eigen::MatrixXf& cells, int turn) {
  Eigen::VectorXf upright(cells.size());
  const Eigen::Index side = cells.rows(), last = side - 1;
  for (Eigen::Index row = 0; row < side; ++row) {
    for (Eigen::Index column = 0; column < side; ++column) {
      const Eigen::Index r[] = {row, column, last - row, last - column};
      const Eigen::Index c[] = {column, last - row, last - column, row};
      upright[r[turn] * side + c[turn]] = cells(row, column);
    }
  }
  return upright;
}

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

TemplateBook::TemplateBook(const MarkerFamily& family, const std::set<int>& ids)
    : patterns_(patternsOf(family, ids)), grid_(family.cells(), family.border()), light_(grid_.size(), 3) {
  for (int row = 0, i = 0; row < grid_.along(); ++row) {
    for (int column = 0; column < grid_.along(); ++column, ++i) light_.row(i) << 1.0f, grid_.x(column), grid_.y(row);
  }
  light_.colwise().normalize();  // the grid is symmetric: they are orthogonal
  const int n = grid_.cells();
  ink_.resize(n * n, static_cast<Eigen::Index>(patterns_.size()));
  for (const auto& [id, pattern] : patterns_) {
    const auto k = static_cast<Eigen::Index>(ids_.size());
    for (int row = 0; row < n; ++row) {
      for (int column = 0; column < n; ++column)
        ink_(row * n + column, k) = static_cast<float>(pattern.at(column, n - 1 - row) - 1.0);
    }
    ids_.push_back(id);
  }
}

const PatternTemplate& TemplateBook::of(int id, int level) const {
  auto& place = templates_[{id, level}];
  if (!place) {
    place = std::make_unique<PatternTemplate>(grid_, patterns_.at(id), kTemplateSd[static_cast<std::size_t>(level)]);
  }
  return *place;
}

/// A round point spread function blurs rows and columns by themselves: what a point sees is 1 (white) plus each cell's
/// ink times its share of row and column.
const TemplateBook::Blurred& TemplateBook::blurred(int level) const {
  const auto number = static_cast<std::size_t>(level);
  Blurred& blurred = blurred_[number];
  if (blurred.unlength.size() > 0) return blurred;
  const int n = grid_.cells();
  blurred.shares.resize(grid_.along(), n);
  for (int point = 0; point < grid_.along(); ++point) {
    const double at = 0.5 * n * (1.0 + grid_.x(point)), sd = kTemplateSd[number];
    for (int cell = 0; cell < n; ++cell) {
      const double share = normalDistribution((cell + 1 - at) / sd) - normalDistribution((cell - at) / sd);
      blurred.shares(point, cell) = static_cast<float>(share);
    }
  }
  blurred.unlength.resize(ink_.cols());
  RowMajor grey(grid_.along(), grid_.along());
  for (Eigen::Index k = 0; k < ink_.cols(); ++k) {
    const Eigen::Map<const RowMajor> ink(ink_.col(k).data(), n, n);
    grey.noalias() = (blurred.shares * ink).eval() * blurred.shares.transpose();
    const Eigen::Map<const Eigen::VectorXf> points(grey.data(), grey.size());
    blurred.unlength[k] = 1.0f / (points - light_ * (light_.transpose() * points).eval()).norm();
  }
  return blurred;
}

std::vector<TemplateBook::Candidate> TemplateBook::compare(const ImageLevels::Samples& samples, int level,
                                                           std::size_t count) const {
  std::vector<Candidate> best;
  if (patterns_.empty() || samples.seen == 0) return best;
  // The light that fits best to what was seen.
  const Eigen::Matrix<float, Eigen::Dynamic, 3> seen = samples.weights.asDiagonal() * light_;
  const Eigen::Matrix3f normal = light_.transpose() * seen;
  Eigen::VectorXf rest = samples.grey;
  // Twice: what rounding leaves of it the first time would count, because codes have light in them too.
  for (int pass = 0; pass < 2; ++pass) rest -= seen * solved(normal, light_.transpose() * rest);
  const float length = rest.norm();
  if (!(length > 0.0f) || !std::isfinite(length)) return best;
  const Blurred& known = blurred(level);
  const Eigen::Index ids = ink_.cols();
  // The product of samples and a code is that of the code's ink and what the samples show of each cell: white, as any
  // light, is in none of what is left. The light's slopes turn with the samples, so these are turned and not the codes.
  const Eigen::Map<const RowMajor> points(rest.data(), grid_.along(), grid_.along());
  const Eigen::MatrixXf cells = known.shares.transpose() * (points * known.shares).eval();
  Eigen::VectorXf all(4 * ids);
  for (int turn = 0; turn < 4; ++turn) {
    const Eigen::VectorXf upright = turned(cells, turn);
    columnDots(ink_.data(), static_cast<int>(ink_.rows()), static_cast<int>(ids), upright.data(),
               all.data() + turn * ids);
    all.segment(turn * ids, ids).array() *= known.unlength.array() / length;
  }
  std::vector<int> order(static_cast<std::size_t>(all.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  count = std::min(count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](int a, int b) { return all[a] > all[b]; });
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(order[i] % ids);
    best.push_back({ids_[k], static_cast<int>(order[i] / ids), all[order[i]]});
  }
  return best;
}

}  // namespace seater_perception
