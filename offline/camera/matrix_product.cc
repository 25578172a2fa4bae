#include "camera/matrix_product.h"

#if RAYGRID_OWN_PRODUCT

#include <immintrin.h>

namespace Eigen {
namespace internal {
namespace {

constexpr Index kPacked = 4;  // rows of a, and columns of b

// Instantiates Eigen's generic kernel for another mapper type, because the
// specialization below replaces it for ProductMapper.
struct EigensMapper : ProductMapper {
  explicit EigensMapper(const ProductMapper& mapper) : ProductMapper(mapper) {}
};
using EigensKernel =
    gebp_kernel<double, double, Index, EigensMapper, 4, 4, false, false>;

// Adds alpha times the product of kPanels panels of rows of a and kCols columns
// of b to c. Excluded from sanitizers for speed; the callers are sanitized.
template <int kPanels, int kCols>
__attribute__((target("avx"), no_sanitize("address", "undefined"))) void
AddProduct(const double* a, Index panel_stride, const double* b, Index depth,
           double alpha, double* c, Index c_stride) {
  __m256d sums[kPanels][kCols];
#pragma GCC unroll 8
  for (int i = 0; i < kPanels * kCols; ++i)
    sums[i / kCols][i % kCols] = _mm256_setzero_pd();
  for (Index k = 0; k < depth; ++k) {
#pragma GCC unroll 2
    for (int p = 0; p < kPanels; ++p) {
      const __m256d rows = _mm256_loadu_pd(a + p * panel_stride + kPacked * k);
#pragma GCC unroll 4
      for (int j = 0; j < kCols; ++j)
        sums[p][j] = _mm256_add_pd(
            sums[p][j],
            _mm256_mul_pd(rows, _mm256_broadcast_sd(b + kCols * k + j)));
    }
  }
  const __m256d factor = _mm256_set1_pd(alpha);
#pragma GCC unroll 8
  for (int i = 0; i < kPanels * kCols; ++i) {
    double* place = c + i / kCols * kPacked + i % kCols * c_stride;
    _mm256_storeu_pd(
        place,
        _mm256_add_pd(_mm256_loadu_pd(place),
                      _mm256_mul_pd(factor, sums[i / kCols][i % kCols])));
  }
}

// AddProduct() for four panels and four columns, with vectors of eight doubles,
// which join two panels.
__attribute__((target("avx512f"), no_sanitize("address", "undefined"))) void
AddWideProduct(const double* a, Index panel_stride, const double* b,
               Index depth, double alpha, double* c, Index c_stride) {
  constexpr int kPairs = 2, kCols = 4;
  __m512d sums[kPairs][kCols];
#pragma GCC unroll 8
  for (int i = 0; i < kPairs * kCols; ++i)
    sums[i / kCols][i % kCols] = _mm512_setzero_pd();
  for (Index k = 0; k < depth; ++k) {
#pragma GCC unroll 2
    for (int p = 0; p < kPairs; ++p) {
      const double* first = a + 2 * p * panel_stride + kPacked * k;
      const __m512d rows =
          _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(first)),
                             _mm256_loadu_pd(first + panel_stride), 1);
#pragma GCC unroll 4
      for (int j = 0; j < kCols; ++j)
        sums[p][j] = _mm512_add_pd(
            sums[p][j], _mm512_mul_pd(rows, _mm512_set1_pd(b[kCols * k + j])));
    }
  }
  const __m512d factor = _mm512_set1_pd(alpha);
#pragma GCC unroll 8
  for (int i = 0; i < kPairs * kCols; ++i) {
    double* place = c + i / kCols * 2 * kPacked + i % kCols * c_stride;
    _mm512_storeu_pd(
        place,
        _mm512_add_pd(_mm512_loadu_pd(place),
                      _mm512_mul_pd(factor, sums[i / kCols][i % kCols])));
  }
}

}  // namespace

void gebp_kernel<double, double, Index, ProductMapper, 4, 4, false,
                 false>::operator()(const ProductMapper& c, const double* a,
                                    const double* b, Index rows, Index depth,
                                    Index cols, double alpha, Index stride_a,
                                    Index stride_b, Index offset_a,
                                    Index offset_b) {
  if (stride_a == -1) stride_a = depth;
  if (stride_b == -1) stride_b = depth;
  const Index packed_rows =
      __builtin_cpu_supports("avx") ? rows / kPacked * kPacked : 0;
  const Index packed_cols = cols / kPacked * kPacked;
  const Index panel_stride = kPacked * stride_a;
  const Index wide_rows = __builtin_cpu_supports("avx512f")
                              ? packed_rows / (4 * kPacked) * (4 * kPacked)
                              : 0;
  for (Index i = 0; i < wide_rows; i += 4 * kPacked)
    for (Index j = 0; j < packed_cols; j += kPacked)
      AddWideProduct(a + i * stride_a + kPacked * offset_a, panel_stride,
                     b + j * stride_b + kPacked * offset_b, depth, alpha,
                     &c(i, j), c.stride());
  for (Index i = 0; i < packed_rows; i += 2 * kPacked) {
    const bool two = i + kPacked < packed_rows;
    const double* panel = a + i * stride_a + kPacked * offset_a;
    for (Index j = i < wide_rows ? packed_cols : 0; j < packed_cols;
         j += kPacked)
      (two ? AddProduct<2, 4>
           : AddProduct<1, 4>)(panel, panel_stride,
                               b + j * stride_b + kPacked * offset_b, depth,
                               alpha, &c(i, j), c.stride());
    for (Index j = packed_cols; j < cols; ++j)
      (two ? AddProduct<2, 1>
           : AddProduct<1, 1>)(panel, panel_stride, b + j * stride_b + offset_b,
                               depth, alpha, &c(i, j), c.stride());
  }
  if (packed_rows < rows)
    EigensKernel()(EigensMapper(c.getSubMapper(packed_rows, 0)),
                   a + packed_rows * stride_a, b, rows - packed_rows, depth,
                   cols, alpha, stride_a, stride_b, offset_a, offset_b);
}

}  // namespace internal
}  // namespace Eigen

#endif
