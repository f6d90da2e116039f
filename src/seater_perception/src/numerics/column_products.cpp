#include "numerics/column_products.h"

#include <cstddef>

#include "numerics/vector_clones.h"

namespace seater_perception {
namespace {

/// Calls sink(c, product of `vector` and column c) for each of `size` columns. Always inline: each clone its own.
template <typename Sink>
[[gnu::always_inline]] inline void eachDot(const float* vector, const float* columns, int column_stride, int n,
                                           int size, const Sink& sink) {
  int c = 0;
  // Four at a time: each number of the vector is read once for them.
  for (; c + 4 <= size; c += 4) {
    const float *b0 = columns + c * column_stride, *b1 = b0 + column_stride, *b2 = b1 + column_stride,
                *b3 = b2 + column_stride;
    float s0 = 0.0F, s1 = 0.0F, s2 = 0.0F, s3 = 0.0F;
    for (int i = 0; i < n; ++i) {
      s0 += vector[i] * b0[i];
      s1 += vector[i] * b1[i];
      s2 += vector[i] * b2[i];
      s3 += vector[i] * b3[i];
    }
    sink(c, s0), sink(c + 1, s1), sink(c + 2, s2), sink(c + 3, s3);
  }
  for (; c < size; ++c) {
    const float* b = columns + c * column_stride;
    float s = 0.0F;
    for (int i = 0; i < n; ++i) s += vector[i] * b[i];
    sink(c, s);
  }
}

}  // namespace

SEATER_VECTOR_CLONES void addColumnProducts(const float* columns, int column_stride, int n, int size, double* sum,
                                            int sum_stride) {
  for (int r = 0; r < size; ++r) {
    const float* a = columns + r * column_stride;
    double* out = sum + r * sum_stride + r;
    eachDot(a, a, column_stride, n, size - r, [out](int c, float product) { out[c] += product; });
  }
}

SEATER_VECTOR_CLONES void columnDots(const float* columns, int column_stride, int n, int size, const float* vector,
                                     float* products) {
  eachDot(vector, columns, column_stride, n, size, [products](int c, float product) { products[c] = product; });
}

SEATER_VECTOR_CLONES void fourSumsOfColumns(const float* columns, int n, int size, const float* weights, float* sums) {
  constexpr int kBlock = 16;  // of each column, as much as four sums leave registers for
  for (int first = 0; first < n; first += kBlock) {
    float s0[kBlock] = {}, s1[kBlock] = {}, s2[kBlock] = {}, s3[kBlock] = {};
    for (int c = 0; c < size; ++c) {
      const float* column = columns + static_cast<std::ptrdiff_t>(c) * n + first;
      const float w0 = weights[c], w1 = weights[size + c], w2 = weights[2 * size + c], w3 = weights[3 * size + c];
      for (int i = 0; i < kBlock; ++i) {
        s0[i] += w0 * column[i];
        s1[i] += w1 * column[i];
        s2[i] += w2 * column[i];
        s3[i] += w3 * column[i];
      }
    }
    for (int i = 0; i < kBlock; ++i) {
      sums[first + i] = s0[i], sums[n + first + i] = s1[i];
      sums[2 * n + first + i] = s2[i], sums[3 * n + first + i] = s3[i];
    }
  }
}

SEATER_VECTOR_CLONES int firstAbove(const float* values, int first, int end, float limit) {
  constexpr int kBlock = 32;
  for (; first + kBlock <= end; first += kBlock) {
    int above = 0;
    for (int i = 0; i < kBlock; ++i) above |= values[first + i] > limit ? 1 : 0;
    if (above != 0) break;
  }
  while (first < end && !(values[first] > limit)) ++first;
  return first;
}

}  // namespace seater_perception
