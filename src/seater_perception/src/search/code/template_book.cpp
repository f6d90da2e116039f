#include "search/code/template_book.h"

#include <algorithm>
#include <cmath>

#include "numerics/column_products.h"
#include "numerics/normal.h"
#include "numerics/solve.h"

namespace seater_perception {
namespace {

constexpr int kBlock = 16;  // codes at once: fourSumsOfColumns

std::vector<int> idsOf(const MarkerFamily& family, const std::set<int>& wanted) {
  std::vector<int> ids;
  for (int id = 0; id < family.count(); ++id) {
    // A dock may name what its family does not have: that is never found.
    if (wanted.empty() || wanted.count(id)) ids.push_back(id);
  }
  return ids;
}

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Along one axis, what two cells (or a cell and the light) have in common in the grid's points.
class AxisSums {
 public:
  AxisSums(const PatternGrid& grid, const Eigen::MatrixXf& shares)
      : n_(grid.cells()), both_(shares.transpose() * shares) {
    Eigen::VectorXf sloping(grid.along());
    for (int i = 0; i < grid.along(); ++i) sloping[i] = grid.x(i);
    even_ = shares.transpose() * Eigen::VectorXf::Ones(grid.along()) / std::sqrt(static_cast<float>(grid.along()));
    sloping_ = shares.transpose() * sloping.normalized();
  }

  /// Of blurred codes, slopes of the light taken off. `ink`: a row for each code, a column for each cell within the
  /// border, which is black. |S K S'|^2 is the sum of (S'S K) and (K S'S), element by element.
  template <typename Ink>
  Eigen::Array<float, kBlock, 1> squaredLengths(const Ink& ink) const {
    using Codes = Eigen::Array<float, kBlock, 1>;
    const auto at = [this](int row, int column) { return static_cast<std::size_t>(row * n_ + column); };
    const Codes black = Codes::Constant(-1.0F), none = Codes::Zero();
    const int bits = static_cast<int>(std::lround(std::sqrt(ink.cols()))), border = (n_ - bits) / 2;
    std::vector<Codes> K(at(n_, 0), black);
    for (int k = 0; k < bits * bits; ++k) K[at(border + k / bits, border + k % bits)] = ink.col(k);
    Codes squares = none, flat = none, across = none, down = none;
    for (int row = 0; row < n_; ++row) {
      Codes even = none, sloping = none;
      for (int column = 0; column < n_; ++column) {
        Codes right = none, left = none;
        for (int k = 0; k < n_; ++k) {
          right += both_(k, column) * K[at(row, k)];
          left += both_(row, k) * K[at(k, column)];
        }
        squares += right * left;
        even += even_[column] * K[at(row, column)];
        sloping += sloping_[column] * K[at(row, column)];
      }
      flat += even_[row] * even, across += even_[row] * sloping, down += sloping_[row] * even;
    }
    return squares - flat.square() - across.square() - down.square();
  }

 private:
  int n_;
  Eigen::MatrixXf both_;
  Eigen::VectorXf even_, sloping_;  // parts of the light, of length 1
};

}  // namespace

TemplateBook::TemplateBook(const MarkerFamily& family, const std::set<int>& ids)
    : family_(family),
      ids_(idsOf(family, ids)),
      grid_(family.cells(), family.border()),
      border_(family.border()),
      light_(grid_.size(), 3) {
  for (int row = 0, i = 0; row < grid_.along(); ++row) {
    for (int column = 0; column < grid_.along(); ++column, ++i) light_.row(i) << 1.0f, grid_.x(column), grid_.y(row);
  }
  light_.colwise().normalize();  // the grid is symmetric: they are orthogonal
  const int n = grid_.cells() - 2 * border_;
  ink_.setZero((static_cast<Eigen::Index>(ids_.size()) + kBlock - 1) / kBlock * kBlock, n * n);
  Eigen::Index k = 0;
  for (const int id : ids_) {
    Eigen::Index cell = 0;
    for (const auto& row : family.code(id)) {
      for (const int white : row) ink_(k, cell++) = white != 0 ? 0.0F : -1.0F;
    }
    ++k;
  }
}

const MarkerPattern& TemplateBook::pattern(int id) const {
  const auto known = patterns_.find(id);
  return known != patterns_.end() ? known->second : patterns_.emplace(id, family_.pattern(id)).first->second;
}

const PatternTemplate& TemplateBook::of(int id, int level) const {
  auto& place = templates_[{id, level}];
  if (!place) {
    place = std::make_unique<PatternTemplate>(grid_, pattern(id), round(level));
  }
  return *place;
}

const RoundBlur& TemplateBook::round(int level) const {
  auto& place = round_[static_cast<std::size_t>(level)];
  if (!place) place.emplace(grid_, kTemplateSd[static_cast<std::size_t>(level)]);
  return *place;
}

/// A round point spread function blurs rows and columns by themselves: what a point sees is 1 (white) plus each cell's
/// ink times its share of row and column.
const TemplateBook::Blurred& TemplateBook::blurred(int level) const {
  Blurred& blurred = blurred_[static_cast<std::size_t>(level)];
  if (blurred.unlength.size() > 0) return blurred;
  blurred.shares = round(level).value.middleCols(1, grid_.cells()).cast<float>();
  blurred.unlength.resize(ink_.rows());
  const AxisSums sums(grid_, blurred.shares);
  for (Eigen::Index first = 0; first < ink_.rows(); first += kBlock)
    blurred.unlength.segment<kBlock>(first) = sums.squaredLengths(ink_.middleRows<kBlock>(first)).rsqrt();
  return blurred;
}

Eigen::VectorXf TemplateBook::restOf(const ImageLevels::Samples& samples) const {
  if (samples.all()) {
    Eigen::VectorXf rest = samples.grey;
    // Twice: what rounding leaves of it the first time would count, because codes have light in them too.
    for (int pass = 0; pass < 2; ++pass) rest -= light_ * Eigen::Vector3f(light_.transpose() * rest);
    return rest;
  }
  // The light that fits best to what was seen.
  const Eigen::Matrix<float, Eigen::Dynamic, 3> seen = samples.weights.asDiagonal() * light_;
  const Eigen::Matrix3f normal = light_.transpose() * seen;
  Eigen::VectorXf rest = samples.grey;
  for (int pass = 0; pass < 2; ++pass) rest -= seen * solved(normal, light_.transpose() * rest);
  return rest;
}

std::vector<TemplateBook::Candidate> TemplateBook::compare(const ImageLevels::Samples& samples, int level,
                                                           std::size_t count) const {
  std::vector<Candidate> best;
  if (ids_.empty() || samples.seen == 0) return best;
  const Eigen::VectorXf rest = restOf(samples);
  const float length = rest.norm();
  if (!(length > 0.0f) || !std::isfinite(length)) return best;
  const Blurred& known = blurred(level);
  // The product of samples and a code is that of the code's ink and what the samples show of each cell: white, as any
  // light, is in none of what is left. The light's slopes turn with the samples, so these are turned and not the codes.
  // The border is the same for all.
  const Eigen::Map<const RowMajor> points(rest.data(), grid_.along(), grid_.along());
  const RowMajor cells = known.shares.transpose() * (points * known.shares).eval();
  const int bits = grid_.cells() - 2 * border_;
  const RowMajor within = cells.block(border_, border_, bits, bits);
  const Eigen::Map<const Eigen::VectorXf> shown(within.data(), within.size());
  const float border = within.sum() - cells.sum();
  Eigen::MatrixXf upright(bits * bits, 4), all(ink_.rows(), 4);
  for (int turn = 0; turn < 4; ++turn) upright.col(turn) = turned(shown, bits, turn);
  fourSumsOfColumns(ink_.data(), static_cast<int>(ink_.rows()), static_cast<int>(ink_.cols()), upright.data(),
                    all.data());
  const auto ids = static_cast<Eigen::Index>(ids_.size());
  for (int turn = 0; turn < 4; ++turn) {
    all.col(turn) = (all.col(turn).array() + border) * known.unlength.array() / length;
    for (Eigen::Index k = 0; k < ids; ++k) {
      if (best.size() == count) {
        const float least = static_cast<float>(best.back().correlation);
        k = firstAbove(all.col(turn).data(), static_cast<int>(k), static_cast<int>(ids), least);
        if (k == ids) break;
      }
      const double correlation = all(k, turn);
      if (best.size() == count) best.pop_back();
      const auto later = [correlation](const Candidate& c) { return correlation > c.correlation; };
      best.insert(std::find_if(best.begin(), best.end(), later),
                  {ids_[static_cast<std::size_t>(k)], turn, correlation});
    }
  }
  return best;
}

}  // namespace seater_perception
