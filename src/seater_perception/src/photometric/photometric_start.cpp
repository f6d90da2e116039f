// What the pixels tell of brightness and noise before a fit begins.
#include <algorithm>
#include <cmath>

#include "photometric/photometric_problem.h"

namespace seater_perception {
namespace {

constexpr int kBrightnessPixels = 512;  // are enough to begin with: the fit itself improves it
// Steps between neighbours: as a scale exact to 1.2 / sqrt(n), that is 5 % and 35 %.
constexpr std::size_t kNoiseSteps = 500, kFewestSteps = 12;

using Seen = std::pair<float, float>;  // white, grey

/// Mean white and median grey of a quarter of the pixels.
std::pair<double, double> typical(std::vector<Seen>::iterator first, std::ptrdiff_t quarter) {
  double white = 0.0;
  for (auto it = first; it != first + quarter; ++it) white += it->first / static_cast<double>(quarter);
  std::nth_element(first, first + quarter / 2, first + quarter,
                   [](const Seen& a, const Seen& b) { return a.second < b.second; });
  return {white, (first + quarter / 2)->second};
}

/// Median of absolute steps between whole grey levels: those that are the same level stand for all within half a level
/// of it, evenly. Without that, a noise of 3 levels would come out as 2.1 or 3.1.
double groupedMedian(std::vector<float>& steps) {
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double level = *middle, low = std::max(0.0, level - 0.5), high = level + 0.5;
  double below = 0.0, within = 0.0;
  for (const float step : steps) {
    below += step < low ? 1.0 : 0.0;
    within += step >= low && step <= high ? 1.0 : 0.0;
  }
  return low + (0.5 * static_cast<double>(steps.size()) - below) / within * (high - low);
}

}  // namespace

std::vector<Brightness> PhotometricProblem::initialBrightness(const PhotometricState& state) const {
  std::vector<Brightness> brightness(samples_->size());
  std::vector<Seen> seen;
  std::vector<float>& white = pool_->scratch();
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    const MarkerSamples& samples = (*samples_)[m];
    MarkerView seen_so;
    if (samples.empty() || !view(m, state, seen_so)) continue;
    const int count = std::min(kBrightnessPixels, samples.batch.count);
    white.resize(static_cast<std::size_t>(samples.batch.padded));
    whiteOfBatch(samples.batch, count, seen_so, white.data());
    seen.clear();
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      seen.emplace_back(white[k], samples.batch.grey[k]);
    }
    for (const FlatBlock& block : samples.blocks)
      seen.emplace_back(static_cast<float>(block.white), static_cast<float>(block.grey));
    if (seen.size() < 8) continue;
    const auto quarter = static_cast<std::ptrdiff_t>(seen.size() / 4);
    std::nth_element(seen.begin(), seen.begin() + quarter, seen.end());
    std::nth_element(seen.begin() + quarter, seen.end() - quarter, seen.end());
    const auto dark = typical(seen.begin(), quarter), light = typical(seen.end() - quarter, quarter);
    Brightness& b = brightness[m];
    b.used = true;
    b.gain = std::max(1.0, (light.second - dark.second) / std::max(0.05, light.first - dark.first));
    b.offset = dark.second - b.gain * dark.first;
  }
  return brightness;
}

bool PhotometricProblem::tellsNoise() const {
  std::size_t count = 0;
  for (const MarkerSamples& samples : *samples_) count += samples.steps.size();
  return count >= kFewestSteps;
}

double PhotometricProblem::flatNoise() const {
  if (!tellsNoise()) return 0.0;
  std::vector<float>& sorted = pool_->scratch();
  sorted.clear();
  for (const MarkerSamples& samples : *samples_) {
    const std::size_t stride = samples.steps.size() / kNoiseSteps + 1;
    for (std::size_t i = 0; i < samples.steps.size(); i += stride) sorted.push_back(std::abs(samples.steps[i]));
  }
  return groupedMedian(sorted) / kNormalMedian * M_SQRT1_2;
}

template <typename Is>
double PhotometricProblem::fraction(const Is& is) const {
  double all = 0.0, those = 0.0;
  for (const MarkerSamples& samples : *samples_) {
    for (int i = 0; i < samples.batch.count; ++i)
      those += is(samples.batch.grey[static_cast<std::size_t>(i)]) ? 1.0 : 0.0;
    for (const FlatBlock& block : samples.blocks) {
      those += is(block.grey) ? block.count : 0.0;
      all += block.count;
    }
    all += samples.batch.count;
  }
  return all > 0.0 ? those / all : 0.0;
}

double PhotometricProblem::fractionBelow(double level) const {
  return fraction([level](double grey) { return grey <= level; });
}

double PhotometricProblem::fractionAbove(double level) const {
  return fraction([level](double grey) { return grey >= level; });
}

}  // namespace seater_perception
