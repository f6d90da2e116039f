#include "photometric/kernel/photometric_kernel.h"

#include <algorithm>
#include <cmath>

#include "numerics/column_products.h"
#include "photometric/kernel/kernel_chunk.h"

namespace seater_perception {
namespace {

// Chosen by hand; the tests of clipped images (photometric_test) notice.
constexpr double kClipSd = 0.02;  // [of the range] most noise that clipping is smoothed with
constexpr double kBlind = 0.2;    // a pixel that feels less of a change than this is clipped

/// The chunk's rows of J: derivatives of the grey level, weighted; the last one is the residual.
struct Rows {
  alignas(64) float J[kColumns][kChunk];
  alignas(64) float mean[kChunk], pass[kChunk];
};

/// Everything of a fit's state that the chunks need, in single precision.
struct Light {
  float offset, gain, slope_u, slope_v, rim;
  float scale_limit;  // of the loss [grey levels]
  float low, high;    // means beyond may be clipped
  bool tukey;
};

/// Noise-free grey levels; returns whether one of them may be clipped.
SEATER_VECTOR_CLONES bool lightUp(const PixelBatch& batch, int first, int n, const Light& light, const Chunk& chunk,
                                  Rows& rows) {
  const float *pu = batch.pu.data() + first, *pv = batch.pv.data() + first;
  int near = 0;
  for (int i = 0; i < n; ++i) {
    const float factor = 1.0F + light.slope_u * pu[i] + light.slope_v * pv[i];
    const float mean = factor * (light.offset + light.gain * chunk.white[i] - light.rim * chunk.outside[i]);
    rows.mean[i] = mean;
    rows.pass[i] = 1.0F;
    near |= static_cast<int>(mean < light.low) | static_cast<int>(mean > light.high);
  }
  return near != 0;
}

/// Residuals, and the rows of J times the square root of each pixel's weight.
SEATER_VECTOR_CLONES void fillRows(const PixelBatch& batch, int first, int n, const Light& light, int shared,
                                   int unknowns, const Chunk& chunk, const float* valid, float* residual, Rows& rows) {
  const float *pu = batch.pu.data() + first, *pv = batch.pv.data() + first, *grey = batch.grey.data() + first;
  float root[kChunk], by_white[kChunk];
  const float limit = light.scale_limit, inverse = 1.0F / limit;
  for (int i = 0; i < n; ++i) {
    const float r = valid[i] * (grey[i] - rows.mean[i]), a = r < 0.0F ? -r : r;
    residual[i] = r;
    const float u = r * inverse, u2 = u * u, inside = 1.0F - (u2 < 1.0F ? u2 : 1.0F);  // its square is Tukey's weight
    const float huber = std::sqrt(limit / (a > limit ? a : limit));
    root[i] = valid[i] * (light.tukey ? inside : huber);
  }
  for (int i = 0; i < n; ++i) {
    const float factor = 1.0F + light.slope_u * pu[i] + light.slope_v * pv[i];
    const float pass = root[i] * rows.pass[i],
                base = light.offset + light.gain * chunk.white[i] - light.rim * chunk.outside[i];
    by_white[i] = pass * factor * light.gain;
    rows.J[shared][i] = pass * factor;
    rows.J[shared + 1][i] = pass * factor * chunk.white[i];
    rows.J[shared + 2][i] = pass * base * pu[i];
    rows.J[shared + 3][i] = pass * base * pv[i];
    rows.J[shared + 4][i] = -pass * factor * chunk.outside[i];
    // With fewer unknowns of brightness, the residual takes the next one's place.
    rows.J[shared + unknowns][i] = root[i] * residual[i];
  }
  for (int k = 0; k < shared; ++k) {
    for (int i = 0; i < n; ++i) rows.J[k][i] = by_white[i] * chunk.by[k][i];
  }
}

/// Compares with the mean of a clipped noisy pixel what may be clipped.
void clip(const PixelBatch& batch, int first, int n, const Weighing& weighing, Rows& rows, float* valid) {
  const double sd = std::min(weighing.scale, kClipSd * (weighing.range.high - weighing.range.low));
  for (int i = 0; i < n; ++i) {
    double pass = 1.0;
    rows.mean[i] = static_cast<float>(clippedMean(rows.mean[i], sd, weighing.range, pass));
    rows.pass[i] = static_cast<float>(pass);
    const double r = batch.grey[static_cast<std::size_t>(first + i)] - rows.mean[i];
    if (pass < kBlind && std::abs(r) < weighing.scale) valid[i] = 0.0F;
  }
}

Light lightOf(const Brightness& b, const Weighing& weighing) {
  const ClipRange& range = weighing.range;
  const double sd = std::min(weighing.scale, kClipSd * (range.high - range.low));
  const bool tukey = weighing.loss == RobustLoss::tukey;
  const auto f = [](double value) { return static_cast<float>(value); };
  return {f(b.offset),
          f(b.gain),
          f(b.slope_u),
          f(b.slope_v),
          f(b.rim),
          f((tukey ? weighing.tukey : kHuber) * weighing.scale),
          f(range.low + kClipReach * sd),
          f(range.high - kClipReach * sd),
          tukey};
}

int chunkLength(int count, int first) {
  const int left = std::min(kChunk, count - first);
  return (left + PixelBatch::kLanes - 1) / PixelBatch::kLanes * PixelBatch::kLanes;
}

}  // namespace

bool MarkerView::make(const Eigen::Isometry3d& pose, double per_metre, double half_sheet, double fx, double fy,
                      const SpreadCovariance& spread, const MarkerSamples& samples, MarkerView& view) {
  const Eigen::Matrix3d R = pose.linear().transpose();  // rows: the marker's axes
  const Eigen::Vector3d t = per_metre * (R * pose.translation());
  const Eigen::Vector3d middle(samples.ray_x, samples.ray_y, 1.0);
  const Eigen::Vector3d at = R * middle;
  // Per pixel: x and y of the batch count in pixels.
  const Eigen::Vector3d by_x = R.col(0) / fx, by_y = R.col(1) / fy;
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto numerator = [&](int k, float out[3]) {
    out[0] = f(t.z() * at[k] - t[k] * at.z());
    out[1] = f(t.z() * by_x[k] - t[k] * by_x.z());
    out[2] = f(t.z() * by_y[k] - t[k] * by_y.z());
  };
  const auto row = [&](int k, float out[3]) { out[0] = f(at[k]), out[1] = f(by_x[k]), out[2] = f(by_y[k]); };
  numerator(0, view.x);
  numerator(1, view.y);
  row(0, view.alpha);
  row(1, view.beta);
  row(2, view.along);
  view.r1x = f(by_x[0]), view.r1y = f(by_y[0]), view.r2x = f(by_x[1]), view.r2y = f(by_y[1]);
  view.r3x = f(by_x[2]), view.r3y = f(by_y[2]);
  view.half_sheet = f(half_sheet);
  view.depth = f(t.z());
  view.inverse_depth = f(1.0 / t.z());
  view.spread = spread;
  view.rays = samples.rays_per_pixel;
  const PixelBatch& b = samples.batch;
  for (const float x : {b.x_min - 1.0F, b.x_max + 1.0F}) {
    for (const float y : {b.y_min - 1.0F, b.y_max + 1.0F}) {
      const double distance = t.z() / (view.along[0] + view.along[1] * x + view.along[2] * y);
      if (!(distance > 1e-3 && distance < 1e7)) return false;
    }
  }
  return true;
}

void accumulateBatch(const PixelBatch& batch, int count, const MarkerView& view, int psf, int brightness_unknowns,
                     const Brightness& brightness, const Weighing& weighing, double sum[kColumns][kColumns],
                     float* residual, float* valid, float* rows_out) {
  const Light light = lightOf(brightness, weighing);
  const int shared = 6 + psf;
  Chunk chunk;
  Rows rows;
  for (int first = 0; first < count; first += kChunk) {
    const int n = chunkLength(count, first);
    renderChunk(batch, first, n, view, psf, chunk);
    for (int i = 0; i < n; ++i) valid[first + i] = first + i < count ? 1.0F : 0.0F;
    if (lightUp(batch, first, n, light, chunk, rows)) clip(batch, first, n, weighing, rows, valid + first);
    fillRows(batch, first, n, light, shared, brightness_unknowns, chunk, valid + first, residual + first, rows);
    addColumnProducts(rows.J[0], kChunk, n, shared + brightness_unknowns + 1, sum[0], kColumns);
    if (!rows_out) continue;
    for (int k = 0; k <= shared + brightness_unknowns; ++k)
      std::copy(rows.J[k], rows.J[k] + std::min(n, count - first), rows_out + k * count + first);
  }
}

void whiteOfBatch(const PixelBatch& batch, int count, const MarkerView& view, float* white) {
  Chunk chunk;
  for (int first = 0; first < count; first += kChunk) {
    const int n = chunkLength(count, first);
    renderChunk(batch, first, n, view, 0, chunk);
    std::copy(chunk.white, chunk.white + std::min(n, count - first), white + first);
  }
}

void renderBatch(const PixelBatch& batch, const MarkerView& view, int psf, float* white, float* by, int stride) {
  Chunk chunk;
  for (int first = 0; first < batch.count; first += kChunk) {
    const int n = chunkLength(batch.count, first), kept = std::min(n, batch.count - first);
    renderChunk(batch, first, n, view, psf, chunk);
    std::copy(chunk.white, chunk.white + kept, white + first);
    for (int k = 0; k < 6 + psf; ++k) std::copy(chunk.by[k], chunk.by[k] + kept, by + k * stride + first);
  }
}

}  // namespace seater_perception
