// The streamed singular value decomposition, compared with a full one.
#include "paper/basis/svd.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>

#include "core/numeric/random.hpp"
#include "core/simd/instruction_sets.hpp"
#include "paper/basis/packed.hpp"
#include "tests/paper/matrix_source.hpp"

namespace slipd {
namespace {

// Random orthogonal directions: eigenvectors of a random symmetric matrix. (Eigen's own SVD takes a minute to
// compile.)
Eigen::MatrixXd directions(Eigen::Index rows, Eigen::Index count, std::uint64_t seed) {
  const Eigen::MatrixXd random = testing::random_matrix(rows, rows, seed).cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(random + random.transpose());
  return solver.eigenvectors().leftCols(count);
}

// Singular values that fall by the factor `fall` from one to the next, on random orthogonal directions.
Eigen::MatrixXf matrix_with_decay(Eigen::Index rows, Eigen::Index columns, double fall) {
  Eigen::VectorXd values(rows);
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = 100 * std::pow(fall, static_cast<double>(i));
  return (directions(rows, rows, 7) * values.asDiagonal() * directions(columns, rows, 8).transpose())
      .cast<float>();
}

TEST(RandomizedSvd, SingularValuesAreThoseOfAFullDecomposition) {
  for (const double fall : {0.5, 0.8, 0.95}) {
    const testing::MatrixSource source(matrix_with_decay(120, 400, fall));
    const Eigen::MatrixXd whole = source.matrix().cast<double>();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> full(whole * whole.transpose(),
                                                              Eigen::EigenvaluesOnly);
    const Svd svd = randomized_svd(source, {.rank = 10});
    for (Eigen::Index i = 0; i < 10; ++i) {  // the eigenvalues come in ascending order
      EXPECT_NEAR(svd.singular_values[i] / std::sqrt(full.eigenvalues()[119 - i]), 1, 1e-4)
          << "fall " << fall << ", value " << i;
    }
    EXPECT_NEAR(svd.total_variance / whole.squaredNorm(), 1, 1e-6);
  }
}

TEST(RandomizedSvd, CoordinatesAreTheProjectionsOnItsBasis) {
  const testing::MatrixSource source(matrix_with_decay(80, 300, 0.7));
  const Svd svd = randomized_svd(source, {.rank = 6, .coordinates = true});
  EXPECT_TRUE(svd.coordinates.isApprox(project(source, svd.basis, 2), 1e-5F));
}

// Zeros within and between the columns, and columns of zeros only.
TEST(PackedColumns, MultiplyAsTheMatrixDoesOnEveryInstructionSet) {
  Eigen::MatrixXf matrix = testing::random_matrix(61, 300, 4);
  matrix = (matrix.array() > 0.3F).select(matrix, 0.0F).eval();
  matrix.col(7).setZero();
  const testing::MatrixSource source(matrix);
  const auto packed = PackedColumns::of(source, 1 << 20, 2);
  ASSERT_TRUE(packed);
  EXPECT_NEAR(packed->squares() / matrix.cast<double>().squaredNorm(), 1, 1e-6);
  for (const Eigen::Index width : {1, 16, 18, 40, 64}) {
    const Eigen::MatrixXf q = testing::random_matrix(61, width, 9);
    const Eigen::MatrixXf image = packed->multiply(q, 2).cast<float>();
    EXPECT_TRUE(image.isApprox(matrix * (matrix.transpose() * q), 1e-5F)) << width;
    EXPECT_TRUE(packed->project(q, 2).isApprox(q.transpose() * matrix, 1e-5F)) << width;
  }
  EXPECT_FALSE(PackedColumns::of(source, 100, 2)) << "no room";

  const std::vector<slipd::TaxelRun> runs{{0, 1}, {5, 22}, {40, 61}};
  std::vector<float> values(39), q(std::size_t{61} * PackedKernels::kWidest);
  RandomStream(2).add_noise(values.data(), values.size(), 1);
  RandomStream(3).add_noise(q.data(), q.size(), 1);
  for (const std::size_t width : {16U, 32U, 48U, 64U}) {
    std::vector<double> wanted(width);
    std::size_t at = 0;
    for (const auto& run : runs) {
      for (std::size_t i = run.first; i < run.end; ++i, ++at) {
        for (std::size_t k = 0; k < width; ++k)
          wanted[k] += static_cast<double>(values[at]) * q[i * width + k];
      }
    }
    for (const PackedKernels* kernels : kernels_at_hand<PackedKernels>()) {
      std::vector<float> z(width), y(61 * width);
      const PackedColumn column{runs, values.data()};
      kernels->project(column, q.data(), width, z.data());
      kernels->add_product(column, z.data(), width, y.data());
      for (std::size_t k = 0; k < width; ++k) {
        EXPECT_NEAR(z[k], wanted[k], 1e-5) << kernels->name;  // rounding of 39 terms
        EXPECT_NEAR(y[5 * width + k], values[1] * z[k], 1e-6) << kernels->name;
        EXPECT_EQ(y[3 * width + k], 0) << kernels->name;
      }
    }
  }
}

TEST(RandomizedSvd, BasisIsOrthonormalAndHoldsWhatTheSingularValuesSay) {
  const testing::MatrixSource source(matrix_with_decay(80, 300, 0.7));
  const Svd svd = randomized_svd(source, {.rank = 6});
  const Eigen::MatrixXf gram = svd.basis.transpose() * svd.basis;
  EXPECT_LT((gram - Eigen::MatrixXf::Identity(6, 6)).cwiseAbs().maxCoeff(),
            1e-5F);  // rounding of float over 80 rows
  const Eigen::MatrixXf projected = project(source, svd.basis, 2);
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(projected.row(i).norm() / svd.singular_values[i], 1, 1e-4);
  }
}

TEST(RandomizedSvd, DoesNotDependOnTheNumberOfThreads) {
  const testing::MatrixSource source(testing::random_matrix(50, 700, 3));
  const Svd one = randomized_svd(source, {.rank = 5, .threads = 1});
  const Svd four = randomized_svd(source, {.rank = 5, .threads = 4});
  EXPECT_EQ(one.basis, four.basis);
  EXPECT_EQ(one.singular_values, four.singular_values);
}

TEST(RandomizedSvd, RankIsClippedToTheMatrix) {
  const testing::MatrixSource source(testing::random_matrix(4, 300, 5));
  const Svd svd = randomized_svd(source, {.rank = 8});
  EXPECT_EQ(svd.basis.cols(), 4);
  EXPECT_NEAR(svd.singular_values.squaredNorm() / svd.total_variance, 1, 1e-5);
}

TEST(RandomizedSvd, AnExceptionOfTheProgressCallbackEndsTheWork) {
  const testing::MatrixSource source(testing::random_matrix(50, 700, 3));
  const auto cancel = [](double, const char*) { throw std::runtime_error("cancelled"); };
  EXPECT_THROW(randomized_svd(source, {.rank = 5}, cancel), std::runtime_error);
}

}  // namespace
}  // namespace slipd
