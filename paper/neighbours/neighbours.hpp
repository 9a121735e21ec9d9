// The k nearest of a model's points, exactly. The only door to FLANN, which stays in the .cpp.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace slipd {

class Neighbours {
 public:
  // `points`: one after the other, `dimensions` values each; at least one, all finite, else
  // std::invalid_argument. Takes a copy.
  Neighbours(std::vector<float> points, std::size_t dimensions);
  Neighbours(Neighbours&&) noexcept;
  Neighbours& operator=(Neighbours&&) noexcept;
  ~Neighbours();

  std::size_t size() const noexcept;
  std::size_t dimensions() const noexcept;

  // A searcher's own memory. One per thread; must not outlive its Neighbours.
  class Query {
   public:
    Query(const Neighbours& of, std::size_t k);
    Query(Query&&) noexcept;
    Query& operator=(Query&&) noexcept;
    ~Query();

    // The min(k, size) nearest to `point`, nearest first; equal distances in no order. Returns how many were
    // found: 0 for a point that is not finite. Valid until the next call. slipd's code allocates nothing
    // here; FLANN makes one small array of per-dimension distances (KDTreeSingleIndex::findNeighbors).
    std::size_t find(std::span<const float> point) noexcept;

    std::span<const std::size_t> indices() const noexcept { return indices_; }
    std::span<const float> squared_distances() const noexcept { return squared_distances_; }

   private:
    struct Search;
    std::unique_ptr<Search> search_;
    std::vector<std::size_t> indices_;
    std::vector<float> squared_distances_;
  };

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slipd
