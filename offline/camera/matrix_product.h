#ifndef RAYGRID_CAMERA_MATRIX_PRODUCT_H
#define RAYGRID_CAMERA_MATRIX_PRODUCT_H

#include <Eigen/Core>

/// Whether products of matrices have a kernel of their own: on x86-64, where
/// code is compiled for every processor, and with the Eigen whose packing of
/// factors it knows.
#if defined(__x86_64__) && !defined(__AVX__) && \
    EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 1)
#define RAYGRID_OWN_PRODUCT 1

namespace Eigen {
namespace internal {

using ProductMapper = blas_data_mapper<double, Index, ColMajor, 0, 1>;

/// The kernel of all products of matrices: (*this)(c, a, b, …) adds alpha a b
/// to c. It takes vectors of four numbers where the processor has them. Eigen
/// itself takes the two that every x86-64 has. The sums have Eigen's order, and
/// a product is rounded before it is added: the bits are the same on every
/// processor.
template <>
struct gebp_kernel<double, double, Index, ProductMapper, 4, 4, false, false> {
  /// The factors are packed: of a, four rows and then their next column; of b,
  /// four columns and then their next row. Strides and offsets count columns of
  /// a and rows of b; -1 is depth.
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
