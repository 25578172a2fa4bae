#include "camera/matrix_product.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace raygrid {
namespace {

#if RAYGRID_OWN_PRODUCT

using Eigen::Index;
using Mapper =
    Eigen::internal::blas_data_mapper<double, Index, Eigen::ColMajor, 0, 1>;

// Another type, for which Eigen's own kernel is compiled.
struct EigensMapper : Mapper {
  using Mapper::Mapper;
};

template <typename AnyMapper>
using Kernel = Eigen::internal::gebp_kernel<double, double, Index, AnyMapper, 4,
                                            4, false, false>;

std::vector<double> RandomNumbers(size_t count, std::mt19937* random) {
  std::normal_distribution<double> normal;
  std::vector<double> numbers(count);
  for (double& number : numbers) number = normal(*random);
  return numbers;
}

TEST(MatrixProduct, HasTheBitsOfEigensKernel) {
  std::mt19937 random(1);
  for (Index rows = 1; rows <= 18; ++rows)
    for (Index cols = 1; cols <= 10; ++cols)
      for (const Index depth : {1, 2, 3, 7, 8, 9, 40})
        for (const Index offset : {0, 3}) {
          const Index stride = depth + 2 * offset, c_stride = rows + 1;
          const auto a = RandomNumbers((rows + 3) * stride, &random);
          const auto b = RandomNumbers((cols + 3) * stride, &random);
          const auto start = RandomNumbers(c_stride * cols, &random);
          std::vector<double> ours = start, eigens = start;
          Kernel<Mapper>()(Mapper(ours.data(), c_stride), a.data(), b.data(),
                           rows, depth, cols, -0.3, stride, stride, offset,
                           offset);
          Kernel<EigensMapper>()(EigensMapper(eigens.data(), c_stride),
                                 a.data(), b.data(), rows, depth, cols, -0.3,
                                 stride, stride, offset, offset);
          ASSERT_EQ(ours, eigens) << rows << " x " << depth << " x " << cols;
          ASSERT_NE(ours, start);
        }
}

#endif

TEST(MatrixProduct, IsTheSumOfProducts) {
  for (const int size : {1, 5, 64, 301}) {
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(size, size + 2);
    const Eigen::MatrixXd b = Eigen::MatrixXd::Random(size + 2, size + 1);
    const Eigen::MatrixXd product = a * b;
    for (int i = 0; i < size; ++i)
      for (int j = 0; j <= size; ++j)
        ASSERT_NEAR(product(i, j), a.row(i).dot(b.col(j)), 1e-12 * size);
  }
}

}  // namespace
}  // namespace raygrid
