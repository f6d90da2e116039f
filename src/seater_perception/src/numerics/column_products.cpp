#include "numerics/column_products.h"

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

SEATER_VECTOR_CLONES void columnDots(const float* columns, int n, int size, const float* vector, float* products) {
  eachDot(vector, columns, n, n, size, [products](int c, float product) { products[c] = product; });
}

}  // namespace seater_perception
