// Exact nearest neighbours, compared with a search of every point.
#include "paper/neighbours/neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/numeric/random.hpp"
#include "paper/method/knn.hpp"

namespace slipd {
namespace {

std::vector<float> random_points(std::size_t count, std::size_t dimensions, std::uint64_t seed) {
  std::vector<float> points(count * dimensions);
  RandomStream(seed).add_noise(points.data(), points.size(), 1);
  return points;
}

std::vector<float> all_squared_distances(const std::vector<float>& points, std::span<const float> to) {
  std::vector<float> distances(points.size() / to.size(), 0.0F);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float d = points[i] - to[i % to.size()];
    distances[i / to.size()] += d * d;
  }
  return distances;
}

TEST(Neighbours, AreThoseOfBruteForce) {
  for (const std::size_t dimensions : {1U, 3U, 8U, 20U}) {
    const auto points = random_points(2000, dimensions, dimensions);
    const Neighbours neighbours(points, dimensions);
    Neighbours::Query query(neighbours, 5);
    const auto queries = random_points(100, dimensions, 99);
    for (std::size_t q = 0; q < 100; ++q) {
      const std::span<const float> point(queries.data() + q * dimensions, dimensions);
      const auto distances = all_squared_distances(points, point);
      auto sorted = distances;
      std::partial_sort(sorted.begin(), sorted.begin() + 5, sorted.end());
      ASSERT_EQ(query.find(point), 5U);
      for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(query.squared_distances()[i], sorted[i], 1e-5F);  // the sums are taken in another order
        EXPECT_NEAR(distances[query.indices()[i]], query.squared_distances()[i], 1e-5F);
      }
    }
  }
}

TEST(Neighbours, APointOfTheSetIsItsOwnNearest) {
  const auto points = random_points(500, 4, 11);
  const Neighbours neighbours(points, 4);
  Neighbours::Query query(neighbours, 1);
  for (std::size_t i = 0; i < 500; i += 37) {
    ASSERT_EQ(query.find(std::span(points).subspan(i * 4, 4)), 1U);
    EXPECT_EQ(query.indices()[0], i);
    EXPECT_EQ(query.squared_distances()[0], 0.0F);
  }
}

TEST(Neighbours, AreNoMoreThanThereArePoints) {
  const Neighbours neighbours({0, 1, 5}, 1);
  Neighbours::Query query(neighbours, 5);
  const float point = 4;
  EXPECT_EQ(query.find({&point, 1}), 3U);
  EXPECT_EQ(query.indices()[0], 2U);
}

TEST(Neighbours, ManyEqualPointsAreFound) {
  const Neighbours neighbours(std::vector<float>(400, 1.0F), 2);
  Neighbours::Query query(neighbours, 5);
  const std::vector<float> point{1, 1};
  EXPECT_EQ(query.find(point), 5U);
}

TEST(Neighbours, AQueryThatIsNotFiniteHasNone) {
  const Neighbours neighbours({0, 1, 5}, 1);
  Neighbours::Query query(neighbours, 2);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(query.find({&nan, 1}), 0U);
}

TEST(Neighbours, MeaninglessPointsAreRefused) {
  EXPECT_THROW(Neighbours({}, 2), std::invalid_argument);
  EXPECT_THROW(Neighbours({1, 2, 3}, 2), std::invalid_argument);
  EXPECT_THROW(Neighbours({1, std::numeric_limits<float>::infinity()}, 2), std::invalid_argument);
}

// Where the answer is a plane over the points, the mean over the neighbours is wrong by the offset of their
// centre, and the fitted plane is exact.
TEST(PlaneAnswer, IsExactOnAPlaneWhereTheMeanIsNot) {
  std::vector<float> points, gamma, friction;
  for (int i = 0; i < 40; ++i) {
    const float x = 0.01F * static_cast<float>(i * i % 17), y = 0.01F * static_cast<float>(i);
    points.insert(points.end(), {x, y});
    gamma.push_back(0.2F + 0.5F * x + 0.8F * y);
    friction.push_back(0.5F);
  }
  const Neighbours neighbours(points, 2);
  Neighbours::Query query(neighbours, 12);
  const std::vector<float> corner{-0.01F, -0.01F};
  EXPECT_NEAR(plane_answer_of(query, corner, points, gamma, friction).gamma, 0.187F, 0.004F);
  EXPECT_GT(answer_of(query, corner, gamma, friction).gamma, 0.2F);
}

}  // namespace
}  // namespace slipd
