// Normal equations from columns of single precision.
#pragma once

namespace seater_perception {

/// sum += upper triangle of the products of `size` columns of `n` numbers each (n a multiple of 16). Column k begins at
/// columns + k * column_stride; the product of columns r and c goes to sum[r * sum_stride + c].
void addColumnProducts(const float* columns, int column_stride, int n, int size, double* sum, int sum_stride);

/// Product of each of `size` columns of n numbers with a vector. Column k begins at columns + k * column_stride.
void columnDots(const float* columns, int column_stride, int n, int size, const float* vector, float* products);

/// Four weighted sums of `size` columns of n numbers each (n a multiple of 16), one after the other: weight k of column
/// c is weights[k * size + c], sum k begins at sums + k * n.
void fourSumsOfColumns(const float* columns, int n, int size, const float* weights, float* sums);

/// The first of values[first] .. values[end - 1] that is larger than `limit`; `end` where there is none.
int firstAbove(const float* values, int first, int end, float limit);

}  // namespace seater_perception
