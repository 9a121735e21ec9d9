// How large a data set is (docs/methods.md §26.1). Its contacts are drawn by core/contact/scene_draws.hpp.
#pragma once

#include <cstddef>

namespace slipd {

// How much of it: as many columns as contacts x loads. The defaults give the 16000 of docs/methods.md §26.1.
struct DataSetSize {
  std::size_t contacts = 320;
  std::size_t loads = 50;
  std::size_t columns() const noexcept { return contacts * loads; }
  bool operator==(const DataSetSize&) const = default;
};

// As many columns, spread over more contacts: better on contacts that training has not seen.
inline constexpr DataSetSize kUnseenFirst{.contacts = 1600, .loads = 10};

// Safety margin at load step `step` of `loads`: linear from 1 to 0; 1 if there is one step only.
constexpr double gamma_of_step(std::size_t step, std::size_t loads) noexcept {
  return loads < 2 ? 1.0 : static_cast<double>(loads - 1 - step) / static_cast<double>(loads - 1);
}

}  // namespace slipd
