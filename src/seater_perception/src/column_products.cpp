#include "column_products.h"

#include "seater_perception/fast_normal.h"

namespace seater_perception {

SEATER_VECTOR_CLONES void addColumnProducts(const float* columns, int column_stride, int n, int size, double* sum,
                                            int sum_stride) {
  for (int r = 0; r < size; ++r) {
    const float* a = columns + r * column_stride;
    double* out = sum + r * sum_stride;
    int c = r;
    // Four at a time: each number of column r is read once for them.
    for (; c + 4 <= size; c += 4) {
      const float *b0 = columns + c * column_stride, *b1 = b0 + column_stride, *b2 = b1 + column_stride,
                  *b3 = b2 + column_stride;
      float s0 = 0.0F, s1 = 0.0F, s2 = 0.0F, s3 = 0.0F;
      for (int i = 0; i < n; ++i) {
        s0 += a[i] * b0[i];
        s1 += a[i] * b1[i];
        s2 += a[i] * b2[i];
        s3 += a[i] * b3[i];
      }
      out[c] += s0, out[c + 1] += s1, out[c + 2] += s2, out[c + 3] += s3;
    }
    for (; c < size; ++c) {
      const float* b = columns + c * column_stride;
      float s = 0.0F;
      for (int i = 0; i < n; ++i) s += a[i] * b[i];
      out[c] += s;
    }
  }
}

SEATER_VECTOR_CLONES void columnDots(const float* columns, int n, int size, const float* vector, float* products) {
  int c = 0;
  for (; c + 4 <= size; c += 4) {
    const float *b0 = columns + c * n, *b1 = b0 + n, *b2 = b1 + n, *b3 = b2 + n;
    float s0 = 0.0F, s1 = 0.0F, s2 = 0.0F, s3 = 0.0F;
    for (int i = 0; i < n; ++i) {
      s0 += vector[i] * b0[i];
      s1 += vector[i] * b1[i];
      s2 += vector[i] * b2[i];
      s3 += vector[i] * b3[i];
    }
    products[c] = s0, products[c + 1] = s1, products[c + 2] = s2, products[c + 3] = s3;
  }
  for (; c < size; ++c) {
    float s = 0.0F;
    for (int i = 0; i < n; ++i) s += vector[i] * columns[c * n + i];
    products[c] = s;
  }
}

}  // namespace seater_perception
