// Built once for each instruction set (slipd_instruction_sets). No function of the standard library is called
// here: what is inline there would exist once for all files, perhaps for the wrong processor.
#include "core/reading/fit/normal_equations/dome_products.hpp"

#include "core/simd/lanes.ipp"

namespace slipd {
namespace {

constexpr std::size_t kDoubles = sizeof(Doubles) / sizeof(double);

// Values from number `first` on; zeros behind the last one, which add nothing to a sum.
struct Reader {
  std::size_t first, count;

  SLIPD_INLINE Doubles operator()(const double* list) const noexcept {
    Doubles values{};
    if (count == kDoubles) {
      __builtin_memcpy(&values, list + first, sizeof values);
    } else {
      for (std::size_t lane = 0; lane < count; ++lane) values[lane] = list[first + lane];
    }
    return values;
  }
};

template <typename Body>
SLIPD_INLINE void for_samples(std::size_t count, const Body& body) noexcept {
  std::size_t first = 0;
  for (; first + kDoubles <= count; first += kDoubles) body(Reader{first, kDoubles});
  if (first < count) body(Reader{first, count - first});
}

SLIPD_INLINE double total(const Doubles& lanes) noexcept {
  double sum = 0;
  for (std::size_t lane = 0; lane < kDoubles; ++lane) sum += lanes[lane];
  return sum;
}

DomeHeights fit_heights(const DomeTask& at) noexcept {
  Doubles oo{}, op{}, dd{}, dq{};
  for_samples(
      at.count, [&](const Reader& read) __attribute__((always_inline)) {
        const Doubles o = read(at.contact.value), d = o - read(at.stick.value);
        oo += o * o;
        op += o * read(at.normal_pa);
        dd += d * d;
        dq += d * read(at.shear_pa);
      });
  return {total(op) / total(oo), total(dq) / total(dd)};
}

// All products of a row of N columns, lane by lane.
template <std::size_t N>
struct Products {
  static constexpr std::size_t kPairs = N * (N + 1) / 2;
  Doubles sums[kPairs] = {};

  SLIPD_INLINE void add(const Doubles (&row)[N]) noexcept {
    std::size_t pair = 0;
#pragma GCC unroll 6
    for (std::size_t i = 0; i < N; ++i) {
#pragma GCC unroll 6
      for (std::size_t j = 0; j <= i; ++j) sums[pair++] += row[i] * row[j];
    }
  }
  SLIPD_INLINE void total_into(double* to) const noexcept {
    for (std::size_t pair = 0; pair < kPairs; ++pair) to[pair] = total(sums[pair]);
  }
};

// One channel after the other, so that all sums of one stay in registers.
void sum_products(const DomeTask& at, const DomeHeights& by, DomeProducts& out) noexcept {
  Products<DomeProducts::kPressure> pressure;
  for_samples(
      at.count, [&](const Reader& read) __attribute__((always_inline)) {
        const Doubles o = read(at.contact.value);
        pressure.add({read(at.contact.d_u), read(at.contact.d_v), read(at.contact.d_x), o,
                      by.pressure * o - read(at.normal_pa)});
      });
  pressure.total_into(out.pressure.data());
  Products<DomeProducts::kShear> shear;
  for_samples(
      at.count, [&](const Reader& read) __attribute__((always_inline)) {
        const Doubles stick = read(at.stick.d_x), d = read(at.contact.value) - read(at.stick.value);
        shear.add({read(at.contact.d_u) - read(at.stick.d_u), read(at.contact.d_v) - read(at.stick.d_v),
                   read(at.contact.d_x) - at.stick_share * stick, d, stick,
                   by.shear * d - read(at.shear_pa)});
      });
  shear.total_into(out.shear.data());
}

}  // namespace

const DomeProductKernels DomeProductKernels::SLIPD_INSTRUCTION_SET{fit_heights, sum_products};

}  // namespace slipd
