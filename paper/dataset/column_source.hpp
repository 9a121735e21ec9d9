// A matrix that is never held whole: its columns are made when asked for. Training threads ask for blocks of
// them.
#pragma once

#include <cstddef>
#include <functional>

namespace slipd {

class ColumnSource {
 public:
  virtual ~ColumnSource() = default;
  virtual std::size_t rows() const noexcept = 0;
  virtual std::size_t columns() const noexcept = 0;

  // Writes columns first … first + count - 1, each of rows() values one after the other, into `out`. Any
  // training thread, several at once; the same column is the same values each time.
  virtual void fill(std::size_t first, std::size_t count, float* out) const = 0;
};

// Share of a piece of work that is done, 0 … 1, and what it is. Called on the thread that asked for the work.
// An exception thrown by it ends the work.
using Progress = std::function<void(double share, const char* what)>;

}  // namespace slipd
