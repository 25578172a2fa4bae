#ifndef RAYGRID_CAMERA_MATRIX_PRODUCT_H
#define RAYGRID_CAMERA_MATRIX_PRODUCT_H

#include <Eigen/Core>

/// 1 if matrix products use raygrid's kernel: on x86-64 without AVX at compile
/// time, and with an Eigen version whose packing of factors is supported.
#if defined(__x86_64__) && !defined(__AVX__) && \
    EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 1)
#define RAYGRID_OWN_PRODUCT 1

namespace Eigen {
namespace internal {

using ProductMapper = blas_data_mapper<double, Index, ColMajor, 0, 1>;

/// The kernel of all matrix products: (*this)(c, a, b, …) adds alpha a b to c.
/// Uses vectors of eight or four doubles if the processor supports them; Eigen
/// uses two, the baseline of x86-64. Sums have Eigen's order, and products are
/// rounded before addition: results are bit-identical on every processor.
template <>
struct gebp_kernel<double, double, Index, ProductMapper, 4, 4, false, false> {
  /// The factors are packed: blocks of four rows of a, column by column; blocks
  /// of four columns of b, row by row. Strides and offsets count columns of a
  /// and rows of b; -1 means depth.
  void operator()(const ProductMapper& c, const double* a, const double* b,
                  Index rows, Index depth, Index cols, double alpha,
                  Index stride_a = -1, Index stride_b = -1, Index offset_a = 0,
                  Index offset_b = 0);
};

}  // namespace internal
}  // namespace Eigen

#else
#define RAYGRID_OWN_PRODUCT 0
#endif

#endif  // RAYGRID_CAMERA_MATRIX_PRODUCT_H
