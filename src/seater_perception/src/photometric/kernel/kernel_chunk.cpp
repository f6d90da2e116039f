#include "photometric/kernel/kernel_chunk.h"

#include <cmath>
#include <cstring>

namespace seater_perception {
namespace {

constexpr float kMaxCorrelation = 0.95F;  // the truncated series in the correlation says nothing beyond
// The mean over a pixel's box is that over four Gaussians at these offsets up to the fifth moment: a = (1/240)^(1/4).
constexpr float kSubOffset = 0.25406637F;

/// Where the rays of the chunk meet the marker, and the point-spread function there [cells].
struct Hits {
  alignas(64) float x[kChunk], y[kChunk], alpha[kChunk], beta[kChunk];
  alignas(64) float gxu[kChunk], gxv[kChunk], gyu[kChunk], gyv[kChunk];  // derivatives by the pixel
  alignas(64) float ix[kChunk], iy[kChunk];                              // 1 / standard deviations
  alignas(64) float rho[kChunk], ratio[kChunk];                          // correlation; sy / sx
  alignas(64) float wu[kChunk], wv[kChunk];  // relative change of the ray's depth by the pixel
};

/// One border along one axis, as each pixel sees it.
struct Border {
  alignas(64) float h[kChunk], density[kChunk], share[kChunk];
};

/// White and its derivatives as of one ray per pixel.
struct Response {
  alignas(64) float value[kChunk], by_x[kChunk], by_y[kChunk], by_log_sx[kChunk], by_log_sy[kChunk], by_rho[kChunk];
};

SEATER_VECTOR_CLONES void meet(const PixelBatch& batch, int first, int n, const MarkerView& view, float du, float dv,
                               Hits& __restrict hits) {
  const float *x = batch.x.data() + first, *y = batch.y.data() + first;
  const float suu = static_cast<float>(view.spread.uu), suv = static_cast<float>(view.spread.uv),
              svv = static_cast<float>(view.spread.vv);
  const MarkerView v = view;
  // Derivatives of the rays by the pixel: the same for all of a camera without distortion.
  const bool bent = batch.bent;
  static const float none[kChunk] = {};
  const float *xu = bent ? batch.xu.data() + first : none, *xv = bent ? batch.xv.data() + first : none;
  const float *yu = bent ? batch.yu.data() + first : none, *yv = bent ? batch.yv.data() + first : none;
  for (int i = 0; i < n; ++i) {
    // What is kept of a bent ray's derivative is its difference from that of a straight one.
    const float a = 1.0F + xu[i], b = xv[i], c = yu[i], d = 1.0F + yv[i];
    const float px = x[i] + a * du + b * dv, py = y[i] + c * du + d * dv;
    const float inverse = 1.0F / (v.along[0] + v.along[1] * px + v.along[2] * py);
    const float alpha = (v.alpha[0] + v.alpha[1] * px + v.alpha[2] * py) * inverse;
    const float beta = (v.beta[0] + v.beta[1] * px + v.beta[2] * py) * inverse;
    const float depth = v.depth * inverse;
    hits.alpha[i] = alpha;
    hits.beta[i] = beta;
    const float x0 = depth * (v.r1x - alpha * v.r3x), x1 = depth * (v.r1y - alpha * v.r3y);
    const float y0 = depth * (v.r2x - beta * v.r3x), y1 = depth * (v.r2y - beta * v.r3y);
    const float gxu = x0 * a + x1 * c, gxv = x0 * b + x1 * d, gyu = y0 * a + y1 * c, gyv = y0 * b + y1 * d;
    // The mean over the point-spread function is not where its middle falls: half the second derivatives of the
    // perspective times the variances.
    const float wu = (v.along[1] * a + v.along[2] * c) * inverse, wv = (v.along[1] * b + v.along[2] * d) * inverse;
    hits.wu[i] = wu;
    hits.wv[i] = wv;
    const float su = suu * wu + suv * wv, sv = suv * wu + svv * wv;
    hits.x[i] = (v.x[0] + v.x[1] * px + v.x[2] * py) * inverse - gxu * su - gxv * sv;
    hits.y[i] = (v.y[0] + v.y[1] * px + v.y[2] * py) * inverse - gyu * su - gyv * sv;
    hits.gxu[i] = gxu;
    hits.gxv[i] = gxv;
    hits.gyu[i] = gyu;
    hits.gyv[i] = gyv;
    const float xx = suu * gxu * gxu + 2.0F * suv * gxu * gxv + svv * gxv * gxv;
    const float yy = suu * gyu * gyu + 2.0F * suv * gyu * gyv + svv * gyv * gyv;
    const float xy = suu * gxu * gyu + suv * (gxu * gyv + gxv * gyu) + svv * gxv * gyv;
    const float ix = 1.0F / std::sqrt(xx), iy = 1.0F / std::sqrt(yy), rho = xy * ix * iy;
    hits.ix[i] = ix;
    hits.iy[i] = iy;
    hits.ratio[i] = yy * iy * ix;
    hits.rho[i] = rho > kMaxCorrelation ? kMaxCorrelation : rho < -kMaxCorrelation ? -kMaxCorrelation : rho;
  }
}

SEATER_VECTOR_CLONES void standardise(const float* at, const float* inverse_sd, const float* first_border, int k, int n,
                                      Border& __restrict border) {
  const float offset = static_cast<float>(k);
  for (int i = 0; i < n; ++i) {
    float h = (at[i] - first_border[i] - offset) * inverse_sd[i];
    h = h > kFlat ? kFlat : h < -kFlat ? -kFlat : h;
    const NormalValue normal = normalAt(h);
    border.h[i] = h;
    border.density[i] = normal.density;
    border.share[i] = normal.distribution;
  }
}

/// out += factor * jump; the derivatives of that by the border's place and the width of the PSF.
SEATER_VECTOR_CLONES void addBorder(const float* jump, const Border& border, int n, float* __restrict value,
                                    float* __restrict by_place, float* __restrict by_width) {
  for (int i = 0; i < n; ++i) {
    const float by_h = border.density[i] * jump[i];
    if (value) value[i] += border.share[i] * jump[i];
    by_place[i] += by_h;
    by_width[i] -= by_h * border.h[i];
  }
}

SEATER_VECTOR_CLONES void addScaled(const float* jump, const float* share, int n, float* __restrict sum) {
  for (int i = 0; i < n; ++i) sum[i] += share[i] * jump[i];
}

/// What the correlation adds where a border of x crosses one of y: the bivariate normal integral from its series in rho
/// up to the fourth order (M. G. Kendall, "Proof of relations connected with the tetrachoric series", Biometrika 1941).
SEATER_VECTOR_CLONES void addCrossing(const float* jump, const Border& x, const Border& y, const float* correlation,
                                      int n, Response& __restrict out) {
  for (int i = 0; i < n; ++i) {
    const float h = x.h[i], k = y.h[i], rho = correlation[i], density = jump[i] * x.density[i] * y.density[i];
    const float hh = h * h, kk = k * k, h2 = hh - 1.0F, k2 = kk - 1.0F, h3 = h * (hh - 3.0F), k3 = k * (kk - 3.0F);
    const float h4 = hh * (hh - 6.0F) + 3.0F, k4 = kk * (kk - 6.0F) + 3.0F;
    const float a2 = rho * rho * 0.5F, a3 = a2 * rho * (1.0F / 3.0F), a4 = a3 * rho * 0.25F;
    const float by_h = -density * (rho * h + a2 * h2 * k + a3 * h3 * k2 + a4 * h4 * k3);
    const float by_k = -density * (rho * k + a2 * k2 * h + a3 * k3 * h2 + a4 * k4 * h3);
    out.value[i] += density * (rho + a2 * h * k + a3 * h2 * k2 + a4 * h3 * k3);
    out.by_rho[i] += density * (1.0F + rho * h * k + a2 * h2 * k2 + a3 * h3 * k3);
    out.by_x[i] += by_h;
    out.by_log_sx[i] -= by_h * h;
    out.by_y[i] += by_k;
    out.by_log_sy[i] -= by_k * k;
  }
}

/// The pattern smoothed by the point-spread function; see PixelBatch::pattern.
void smooth(const PixelBatch& batch, int first, int n, const Hits& hits, Response& out) {
  const int K = batch.borders;
  Border columns[PixelBatch::kMostBorders], rows[PixelBatch::kMostBorders];
  for (int k = 0; k < K; ++k) {
    standardise(hits.x, hits.ix, batch.column.data() + first, k, n, columns[k]);
    standardise(hits.y, hits.iy, batch.row.data() + first, k, n, rows[k]);
  }
  const std::size_t bytes = static_cast<std::size_t>(n) * sizeof(float);
  std::memcpy(out.value, batch.plane(0) + first, bytes);
  for (float* zero : {out.by_x, out.by_y, out.by_log_sx, out.by_log_sy, out.by_rho}) std::memset(zero, 0, bytes);
  alignas(64) float jump[kChunk];
  const auto crossing = [&](int i, int j) { return batch.plane(1 + 2 * K + j * K + i) + first; };
  for (int i = 0; i < K; ++i) {
    std::memcpy(jump, batch.plane(1 + i) + first, bytes);
    for (int j = 0; j < K; ++j) addScaled(crossing(i, j), rows[j].share, n, jump);
    // The share of crossings is counted with the rows, once.
    addBorder(jump, columns[i], n, nullptr, out.by_x, out.by_log_sx);
    addScaled(batch.plane(1 + i) + first, columns[i].share, n, out.value);
  }
  for (int j = 0; j < K; ++j) {
    std::memcpy(jump, batch.plane(1 + K + j) + first, bytes);
    for (int i = 0; i < K; ++i) addScaled(crossing(i, j), columns[i].share, n, jump);
    addBorder(jump, rows[j], n, out.value, out.by_y, out.by_log_sy);
    for (int i = 0; i < K; ++i) addCrossing(crossing(i, j), columns[i], rows[j], hits.rho, n, out);
  }
}

// With e1 = r1 - alpha r3 and e2 = r2 - beta r3, the ray's hit moves by dx = -e1 . d + w . (e1 x X), the gradients of x
// and y by the pixel change by (dlambda / lambda - alpha w2) grad x + (w3 + alpha w1) grad y and alike, which gives the
// changes of sx, sy and rho.
SEATER_VECTOR_CLONES void addDerivatives(const Hits& hits, const Response& response, const MarkerView& view, int psf,
                                         float share, int n, Chunk& __restrict chunk) {
  const float inverse_depth = view.inverse_depth;
  const float half =
      psf > 1 ? 0.0F : 0.5F / static_cast<float>(view.spread.uu);  // a round PSF's relative change with its variance
  const float round = psf > 1 ? 0.0F : 1.0F;
  for (int i = 0; i < n; ++i) {
    const float gx = share * response.by_x[i] * hits.ix[i], gy = share * response.by_y[i] * hits.iy[i];
    const float bx = share * response.by_log_sx[i], by = share * response.by_log_sy[i];
    const float rho = hits.rho[i], alpha = hits.alpha[i], beta = hits.beta[i], x = hits.x[i], y = hits.y[i];
    const float twist = share * response.by_rho[i] * (1.0F - rho * rho), ratio = hits.ratio[i];
    const float p = (bx * rho + twist) * ratio, q = -(by * rho + twist) / ratio;
    const float away = alpha * gx + beta * gy + (bx + by) * inverse_depth;
    chunk.white[i] += share * response.value[i];
    chunk.by[0][i] -= gx;
    chunk.by[1][i] -= gy;
    chunk.by[2][i] += away;
    chunk.by[3][i] += y * away + alpha * p + beta * by;
    chunk.by[4][i] += -x * away - alpha * bx + beta * q;
    chunk.by[5][i] += y * gx - x * gy + p + q;
    const float wu = hits.wu[i], wv = hits.wv[i];
    const float shift = gx * (hits.gxu[i] * wu + hits.gxv[i] * wv) + gy * (hits.gyu[i] * wu + hits.gyv[i] * wv);
    chunk.by[6][i] += half * (bx + by) - round * shift;
  }
  if (psf < 3) return;
  for (int i = 0; i < n; ++i) {
    const float ix = hits.ix[i], iy = hits.iy[i], rho = hits.rho[i], by_rho = share * response.by_rho[i];
    const float cx = 0.5F * (share * response.by_log_sx[i] - rho * by_rho) * ix * ix;
    const float cy = 0.5F * (share * response.by_log_sy[i] - rho * by_rho) * iy * iy, cxy = by_rho * ix * iy;
    const float xu = hits.gxu[i], xv = hits.gxv[i], yu = hits.gyu[i], yv = hits.gyv[i];
    const float gx = share * response.by_x[i] * ix, gy = share * response.by_y[i] * iy, wu = hits.wu[i],
                wv = hits.wv[i];
    const float gu = gx * xu + gy * yu, gv = gx * xv + gy * yv;
    chunk.by[6][i] += cx * xu * xu + cy * yu * yu + cxy * xu * yu - gu * wu;
    chunk.by[7][i] += 2.0F * (cx * xu * xv + cy * yu * yv) + cxy * (xu * yv + xv * yu) - gu * wv - gv * wu;
    chunk.by[8][i] += cx * xv * xv + cy * yv * yv + cxy * xv * yv - gv * wv;
  }
}

/// What the point-spread function sees beyond the sheet; of each axis the nearer end alone is felt.
SEATER_VECTOR_CLONES void addOutside(const Hits& hits, float half_sheet, float share, int n,
                                     float* __restrict outside) {
  for (int i = 0; i < n; ++i) {
    const float from_x = hits.x[i] < 0.0F ? -hits.x[i] : hits.x[i], from_y = hits.y[i] < 0.0F ? -hits.y[i] : hits.y[i];
    const float x = normalAt((half_sheet - from_x) * hits.ix[i]).distribution;
    const float y = normalAt((half_sheet - from_y) * hits.iy[i]).distribution;
    outside[i] += share * (1.0F - x * y);
  }
}

}  // namespace

void renderChunk(const PixelBatch& batch, int first, int n, const MarkerView& view, int psf, Chunk& chunk) {
  Hits hits;
  Response response;
  std::memset(&chunk, 0, sizeof chunk);
  const float share = 1.0F / static_cast<float>(view.rays);
  for (int ray = 0; ray < view.rays; ++ray) {
    const float offset = view.rays == 1 ? 0.0F : kSubOffset;
    meet(batch, first, n, view, ray % 2 ? offset : -offset, ray / 2 ? offset : -offset, hits);
    smooth(batch, first, n, hits, response);
    if (view.half_sheet > 0.0F) addOutside(hits, view.half_sheet, share, n, chunk.outside);
    addDerivatives(hits, response, view, psf, share, n, chunk);
  }
}

}  // namespace seater_perception
