#include "photometric/evaluation.h"

#include <algorithm>
#include <cmath>

#include "photometric/photometric_problem.h"

namespace seater_perception {
namespace {

// The median of n residuals is exact to 1.25 / sqrt(n) of their standard deviation, as a scale to 1.2 / sqrt(n).
constexpr std::size_t kSpreadPixels = 600;    // of one marker: 5 %
constexpr std::size_t kFewestForSpread = 30;  // of all: 20 %

}  // namespace

EvaluationPool::Lease EvaluationPool::take() {
  if (free_.empty()) return Lease(new Buffers, Return{this});
  Buffers* buffers = free_.back().release();
  free_.pop_back();
  return Lease(buffers, Return{this});
}

LossSums Evaluation::loss(const Weighing& weighing, double part) const {
  LossSums total;
  const auto& samples = problem_->samples();
  for (std::size_t m = 0; m < samples.size(); ++m) {
    const int wanted = static_cast<int>(std::ceil(part * samples[m].batch.count));
    const LossSums s = sumLoss(data_->residuals[m].data(), data_->valid[m].data(),
                               std::min(wanted, data_->evaluated[m]), weighing.scale, weighing.loss, weighing.tukey);
    total.all += s.all, total.inliers += s.inliers, total.cost += s.cost, total.weights += s.weights;
    total.slopes += s.slopes, total.squares += s.squares, total.weighted += s.weighted, total.psi2 += s.psi2;
  }
  return total;
}

double Evaluation::spread(double quantile) const {
  std::vector<float>& sorted = data_.get_deleter().pool->scratch();
  sorted.clear();
  for (std::size_t m = 0; m < data_->blocks.size(); ++m) {
    const auto count = static_cast<std::size_t>(data_->evaluated[m]), stride = count / kSpreadPixels + 1;
    for (std::size_t i = 0; i < count; i += stride) {
      if (data_->valid[m][i] > 0.0F) sorted.push_back(std::abs(data_->residuals[m][i]));
    }
  }
  if (sorted.size() < kFewestForSpread) return 0.0;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle / (quantile > 0.4 ? kNormalMedian : kNormalQuartile);
}

double Evaluation::residualSquares() const {
  double squares = data_->block_squares;
  for (std::size_t m = 0; m < data_->blocks.size(); ++m) {
    for (int i = 0; i < data_->evaluated[m]; ++i) {
      const double r = data_->residuals[m][static_cast<std::size_t>(i)];
      squares += r * r;
    }
  }
  return squares;
}

double Evaluation::greySquares() const {
  double squares = 0.0;
  const auto& samples = problem_->samples();
  for (std::size_t m = 0; m < samples.size(); ++m) {
    double sum = 0.0, square = 0.0, count = 0.0;
    const auto add = [&](double grey, double n) { sum += n * grey, square += n * grey * grey, count += n; };
    for (int i = 0; i < data_->evaluated[m]; ++i) add(samples[m].batch.grey[static_cast<std::size_t>(i)], 1.0);
    for (const FlatBlock& block : samples[m].blocks) add(block.grey, block.count);
    if (count > 0.0) squares += square - sum * sum / count;
  }
  return squares;
}

}  // namespace seater_perception
