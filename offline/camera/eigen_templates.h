/// Explicit instantiations of Eigen templates that several stages use, each of
/// which takes seconds to compile. They are compiled once, in
/// eigen_templates.cc, which includes this file with RAYGRID_TEMPLATE defined;
/// hence there is no include guard. All other files get it with the precompiled
/// headers. Templates that are not listed are instantiated implicitly.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "camera/matrix_product.h"

// Other versions may differ internally; then each source instantiates its own.
#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 1)

#ifndef RAYGRID_TEMPLATE
#define RAYGRID_TEMPLATE extern template
#endif

namespace Eigen {

RAYGRID_TEMPLATE void ColPivHouseholderQR<MatrixXd>::computeInPlace();
RAYGRID_TEMPLATE void PartialPivLU<MatrixXd>::compute();
RAYGRID_TEMPLATE LLT<MatrixXd>& LLT<MatrixXd>::compute(
    const EigenBase<MatrixXd>&);
RAYGRID_TEMPLATE LDLT<MatrixXd>& LDLT<MatrixXd>::compute(
    const EigenBase<MatrixXd>&);
RAYGRID_TEMPLATE LDLT<Matrix3d>& LDLT<Matrix3d>::compute(
    const EigenBase<Matrix3d>&);
RAYGRID_TEMPLATE LDLT<Matrix<double, 6, 6>>&
LDLT<Matrix<double, 6, 6>>::compute(const EigenBase<Matrix<double, 6, 6>>&);
RAYGRID_TEMPLATE void LDLT<MatrixXd>::_solve_impl_transposed<true>(
    const VectorXd&, VectorXd&) const;
RAYGRID_TEMPLATE void LDLT<Matrix3d>::_solve_impl_transposed<true>(
    const Vector3d&, Vector3d&) const;
RAYGRID_TEMPLATE void LDLT<Matrix<double, 6, 6>>::_solve_impl_transposed<true>(
    const Matrix<double, 6, 1>&, Matrix<double, 6, 1>&) const;
RAYGRID_TEMPLATE JacobiSVD<Matrix3d>& JacobiSVD<Matrix3d>::compute(
    const Matrix3d&, unsigned int);
// Used by Quaterniond::FromTwoVectors() for opposite vectors.
RAYGRID_TEMPLATE JacobiSVD<Matrix<double, 2, 3>>&
JacobiSVD<Matrix<double, 2, 3>>::compute(const Matrix<double, 2, 3>&,
                                         unsigned int);
RAYGRID_TEMPLATE JacobiSVD<MatrixXd>& JacobiSVD<MatrixXd>::compute(
    const MatrixXd&, unsigned int);
RAYGRID_TEMPLATE Matrix4d umeyama(const MatrixBase<Matrix3Xd>&,
                                  const MatrixBase<Matrix3Xd>&, bool);

namespace internal {

// SelfAdjointEigenSolver of 2 x 2, 6 x 6, 9 x 9 and dynamic size.
RAYGRID_TEMPLATE void tridiagonalization_inplace(Matrix2d&, Vector2d&,
                                                 Matrix<double, 1, 1>&,
                                                 Matrix<double, 1, 1>&, bool);
RAYGRID_TEMPLATE void tridiagonalization_inplace(Matrix<double, 6, 6>&,
                                                 Matrix<double, 6, 1>&,
                                                 Matrix<double, 5, 1>&,
                                                 Matrix<double, 5, 1>&, bool);
RAYGRID_TEMPLATE void tridiagonalization_inplace(Matrix<double, 9, 9>&,
                                                 Matrix<double, 9, 1>&,
                                                 Matrix<double, 8, 1>&,
                                                 Matrix<double, 8, 1>&, bool);
RAYGRID_TEMPLATE void tridiagonalization_inplace(MatrixXd&, VectorXd&,
                                                 VectorXd&, VectorXd&, bool);
RAYGRID_TEMPLATE ComputationInfo computeFromTridiagonal_impl(
    Vector2d&, Matrix<double, 1, 1>&, const Index, bool, Matrix2d&);
RAYGRID_TEMPLATE ComputationInfo
computeFromTridiagonal_impl(Matrix<double, 6, 1>&, Matrix<double, 5, 1>&,
                            const Index, bool, Matrix<double, 6, 6>&);
RAYGRID_TEMPLATE ComputationInfo
computeFromTridiagonal_impl(Matrix<double, 9, 1>&, Matrix<double, 8, 1>&,
                            const Index, bool, Matrix<double, 9, 9>&);
RAYGRID_TEMPLATE ComputationInfo computeFromTridiagonal_impl(VectorXd&,
                                                             VectorXd&,
                                                             const Index, bool,
                                                             MatrixXd&);

// Products, and solutions of triangular systems.
#if !RAYGRID_OWN_PRODUCT
RAYGRID_TEMPLATE struct gebp_kernel<
    double, double, Index, blas_data_mapper<double, Index, ColMajor, 0, 1>,
    gebp_traits<double, double>::mr, gebp_traits<double, double>::nr, false,
    false>;
#endif
RAYGRID_TEMPLATE struct gemm_pack_lhs<
    double, Index, const_blas_data_mapper<double, Index, ColMajor>,
    gebp_traits<double, double>::mr, gebp_traits<double, double>::LhsProgress,
    gebp_traits<double, double>::LhsPacket4Packing, ColMajor, false, false>;
RAYGRID_TEMPLATE struct gemm_pack_lhs<
    double, Index, const_blas_data_mapper<double, Index, RowMajor>,
    gebp_traits<double, double>::mr, gebp_traits<double, double>::LhsProgress,
    gebp_traits<double, double>::LhsPacket4Packing, RowMajor, false, false>;
RAYGRID_TEMPLATE struct gemm_pack_rhs<
    double, Index, const_blas_data_mapper<double, Index, ColMajor>,
    gebp_traits<double, double>::nr, ColMajor, false, false>;
RAYGRID_TEMPLATE struct gemm_pack_rhs<
    double, Index, const_blas_data_mapper<double, Index, RowMajor>,
    gebp_traits<double, double>::nr, RowMajor, false, false>;
RAYGRID_TEMPLATE struct gemm_pack_rhs<
    double, Index, blas_data_mapper<double, Index, ColMajor, 0, 1>,
    gebp_traits<double, double>::nr, ColMajor, false, true>;
RAYGRID_TEMPLATE void evaluateProductBlockingSizesHeuristic<double, double, 1>(
    Index&, Index&, Index&, Index);
RAYGRID_TEMPLATE void evaluateProductBlockingSizesHeuristic<double, double, 4>(
    Index&, Index&, Index&, Index);
RAYGRID_TEMPLATE struct general_matrix_vector_product<
    Index, double, const_blas_data_mapper<double, Index, ColMajor>, ColMajor,
    false, double, const_blas_data_mapper<double, Index, ColMajor>, false, 0>;
RAYGRID_TEMPLATE struct general_matrix_vector_product<
    Index, double, const_blas_data_mapper<double, Index, ColMajor>, ColMajor,
    false, double, const_blas_data_mapper<double, Index, RowMajor>, false, 0>;
RAYGRID_TEMPLATE struct general_matrix_vector_product<
    Index, double, const_blas_data_mapper<double, Index, RowMajor>, RowMajor,
    false, double, const_blas_data_mapper<double, Index, ColMajor>, false, 0>;
RAYGRID_TEMPLATE struct general_matrix_vector_product<
    Index, double, const_blas_data_mapper<double, Index, RowMajor>, RowMajor,
    false, double, const_blas_data_mapper<double, Index, RowMajor>, false, 1>;
RAYGRID_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Lower,
                                                false, ColMajor, ColMajor, 1>;
RAYGRID_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper,
                                                false, ColMajor, ColMajor, 1>;
RAYGRID_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper,
                                                false, RowMajor, ColMajor, 1>;
RAYGRID_TEMPLATE struct triangular_solve_matrix<
    double, Index, OnTheRight, Upper, false, RowMajor, ColMajor, 1>;
RAYGRID_TEMPLATE struct triangular_solve_matrix<
    double, Index, OnTheLeft, Lower | UnitDiag, false, ColMajor, ColMajor, 1>;
RAYGRID_TEMPLATE struct triangular_solve_matrix<
    double, Index, OnTheLeft, Upper | UnitDiag, false, RowMajor, ColMajor, 1>;

// Products by the triangular factors of Householder reflections.
RAYGRID_TEMPLATE struct product_triangular_matrix_matrix<
    double, Index, Lower, true, ColMajor, false, ColMajor, false, ColMajor, 1>;
RAYGRID_TEMPLATE struct product_triangular_matrix_matrix<
    double, Index, Lower | UnitDiag, true, ColMajor, false, ColMajor, false,
    ColMajor, 1>;
RAYGRID_TEMPLATE struct product_triangular_matrix_matrix<
    double, Index, Upper, true, RowMajor, false, ColMajor, false, ColMajor, 1>;
RAYGRID_TEMPLATE struct product_triangular_matrix_matrix<
    double, Index, Upper | UnitDiag, true, RowMajor, false, ColMajor, false,
    ColMajor, 1>;

}  // namespace internal
}  // namespace Eigen

#endif
