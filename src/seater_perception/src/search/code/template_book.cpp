#include "search/code/template_book.h"

#include <algorithm>
#include <cmath>

#include "numerics/column_products.h"
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

/// What the quadrilateral shows, as the print would stand upright in it; `along` points a side.
Eigen::VectorXf turned(const Eigen::VectorXf& samples, int along, int turn) {
  Eigen::VectorXf upright(samples.size());
  const int last = along - 1;
  for (int row = 0, i = 0; row < along; ++row) {
    for (int column = 0; column < along; ++column, ++i) {
      const int r[] = {row, column, last - row, last - column};
      const int c[] = {column, last - row, last - column, row};
      upright[r[turn] * along + c[turn]] = samples[i];
    }
  }
  return upright;
}

}  // namespace

TemplateBook::TemplateBook(const MarkerFamily& family, const std::set<int>& ids)
    : patterns_(patternsOf(family, ids)), grid_(family.cells(), family.border()), light_(grid_.size(), 3) {
  for (int row = 0, i = 0; row < grid_.along(); ++row) {
    for (int column = 0; column < grid_.along(); ++column, ++i) light_.row(i) << 1.0f, grid_.x(column), grid_.y(row);
  }
  light_.colwise().normalize();  // the grid is symmetric: they are orthogonal
}

const PatternTemplate& TemplateBook::of(int id, int level) const {
  auto& place = templates_[{id, level}];
  if (!place) {
    place = std::make_unique<PatternTemplate>(grid_, patterns_.at(id), kTemplateSd[static_cast<std::size_t>(level)]);
  }
  return *place;
}

const Eigen::MatrixXf& TemplateBook::codes(int level) const {
  Eigen::MatrixXf& codes = codes_[static_cast<std::size_t>(level)];
  if (codes.cols() > 0) return codes;
  codes.resize(grid_.size(), static_cast<Eigen::Index>(patterns_.size()));
  Eigen::Index k = 0;
  for (const auto& [id, pattern] : patterns_) codes.col(k++) = of(id, level).values();
  codes -= light_ * (light_.transpose() * codes).eval();
  codes.colwise().normalize();
  return codes;
}

std::vector<TemplateBook::Candidate> TemplateBook::compare(const ImageLevels::Samples& samples, int level,
                                                           std::size_t count) const {
  std::vector<Candidate> best;
  if (patterns_.empty() || samples.seen == 0) return best;
  // The light that fits best to what was seen.
  const Eigen::Matrix<float, Eigen::Dynamic, 3> seen = samples.weights.asDiagonal() * light_;
  const Eigen::Matrix3f normal = light_.transpose() * seen;
  const Eigen::Vector3f light = solved(normal, light_.transpose() * samples.grey);
  const Eigen::VectorXf rest = samples.grey - seen * light;
  const float length = rest.norm();
  if (!(length > 0.0f) || !std::isfinite(length)) return best;
  const Eigen::MatrixXf& known = codes(level);
  const Eigen::Index ids = known.cols();
  // The light's slopes turn with the samples, so these are turned and not the codes: the table of a big dictionary is a
  // quarter, and stays in the processor's cache.
  Eigen::VectorXf all(4 * ids);
  for (int turn = 0; turn < 4; ++turn) {
    const Eigen::VectorXf upright = turned(rest, grid_.along(), turn);
    columnDots(known.data(), static_cast<int>(known.rows()), static_cast<int>(ids), upright.data(),
               all.data() + turn * ids);
  }
  all /= length;
  std::vector<int> order(static_cast<std::size_t>(all.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  count = std::min(count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](int a, int b) { return all[a] > all[b]; });
  for (std::size_t i = 0; i < count; ++i) {
    auto entry = patterns_.begin();
    std::advance(entry, order[i] % ids);
    best.push_back({entry->first, static_cast<int>(order[i] / ids), all[order[i]]});
  }
  return best;
}

}  // namespace seater_perception
