#include "core/estimate/kernel_ratio.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace slipd {
namespace {

// Position i of a transform without its last step, the reversal of bits; signed.
double frequency_at(std::size_t i, std::size_t length) noexcept {
  std::size_t frequency = 0;
  for (std::size_t bit = 1; bit < length; bit *= 2) {
    frequency = 2 * frequency + (i & 1);
    i /= 2;
  }
  const auto signed_length = static_cast<double>(length), at = static_cast<double>(frequency);
  return at > signed_length / 2 ? at - signed_length : at;
}

}  // namespace

KernelRatio::Roots::Roots(std::size_t n) : length(n), cosine(n / 2), sine(n / 2) {
  for (std::size_t j = 0; j < n / 2; ++j) {
    const double angle_rad = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n);
    cosine[j] = static_cast<float>(std::cos(angle_rad));
    sine[j] = static_cast<float>(std::sin(angle_rad));
  }
}

// The ratio's kernel falls only with the third power of the distance. So it is found on a plane that is
// kWider times as wide as the transforms, of which the distances between two taxels are kept: the filter
// reaches from each taxel to each other one, and not around.
KernelRatio::KernelRatio(const TaxelLayout::Grid& grid, double depth_m, double least_felt)
    : columns_(grid.columns),
      rows_(grid.rows),
      along_x_(std::bit_ceil(2 * grid.columns)),
      along_y_(std::bit_ceil(2 * grid.rows)) {
  const std::size_t width = along_x_.length, height = along_y_.length, size = width * height;
  spectrum_.resize(size);
  product_.resize(size);
  lines_.resize(size);
  const Roots wide_x(kWider * width), wide_y(kWider * height);
  Plane wide, turned;
  wide.resize(wide_x.length * wide_y.length);
  turned.resize(wide.re.size());
  const auto wave_number = [&](std::size_t i, std::size_t length) {  // times the depth
    return 2 * std::numbers::pi * frequency_at(i, length) / (static_cast<double>(length) * grid.pitch_m) *
           depth_m;
  };
  // The spectrum's real part of the kernel whose ratio is `real`, its imaginary part that of `imaginary`.
  const auto keep = [&](const auto& real, const auto& imaginary) {
    for (std::size_t u = 0; u < wide_x.length; ++u) {
      const double kx = wave_number(u, wide_x.length);
      for (std::size_t v = 0; v < wide_y.length; ++v) {
        const double ky = wave_number(v, wide_y.length), k = std::hypot(kx, ky);
        const double felt = (1 + k) * std::exp(-k) < least_felt ? 0 : 1 / (1 + k);
        wide.re[u * wide_y.length + v] = static_cast<float>(felt * real(kx, ky, k > 0 ? 1 / k : 0));
        wide.im[u * wide_y.length + v] = static_cast<float>(felt * imaginary(kx, ky, k > 0 ? 1 / k : 0));
      }
    }
    backward(wide, wide_x, wide_y.length);
    turn(wide, turned, wide_x.length, wide_y.length);
    backward(turned, wide_y, wide_x.length);
    const auto kept = [](std::size_t i, std::size_t length) {
      return i < length / 2 ? i : (kWider - 1) * length + i;
    };
    const auto scale = 1 / static_cast<float>(wide.re.size() * size);
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        // No two taxels are that far apart.
        const bool within = x != width / 2 && y != height / 2;
        const std::size_t from = kept(y, height) * wide_x.length + kept(x, width);
        lines_.re[y * width + x] = within ? scale * turned.re[from] : 0;
        lines_.im[y * width + x] = within ? scale * turned.im[from] : 0;
      }
    }
    forward(lines_, along_y_, width);
    turn(lines_, spectrum_, height, width);
    forward(spectrum_, along_x_, height);
  };
  keep([](double kx, double, double per_k) { return 1 - kx * kx * per_k; },
       [](double, double ky, double per_k) { return 1 - ky * ky * per_k; });
  xx_ = spectrum_.re;
  yy_ = spectrum_.im;
  keep([](double kx, double ky, double per_k) { return -kx * ky * per_k; },
       [](double, double, double) { return 0.0; });
  xy_ = spectrum_.re;
  double squares = 0;
  for (std::size_t i = 0; i < size; ++i)
    squares += 0.5 * (xx_[i] * xx_[i] + 2 * xy_[i] * xy_[i] + yy_[i] * yy_[i]);
  noise_gain_ = static_cast<double>(size) * squares;
}

std::size_t KernelRatio::memory_bytes() const noexcept {
  return sizeof(*this) + sizeof(float) * (3 * xx_.size() + 4 * spectrum_.re.size() + 2 * lines_.re.size() +
                                          2 * along_x_.cosine.size() + 2 * along_y_.cosine.size());
}

// Decimation in frequency (Gentleman and Sande 1966) of `width` transforms side by side.
void KernelRatio::forward(Plane& plane, const Roots& roots, std::size_t width) noexcept {
  const std::size_t length = roots.length;
  for (std::size_t half = length / 2, step = 1; half >= 1; half /= 2, step *= 2) {
    for (std::size_t block = 0; block < length; block += 2 * half) {
      for (std::size_t j = 0; j < half; ++j) {
        float* const re = plane.re.data() + (block + j) * width;
        float* const im = plane.im.data() + (block + j) * width;
        float* const re2 = re + half * width;
        float* const im2 = im + half * width;
        const float c = roots.cosine[j * step], s = -roots.sine[j * step];
#pragma omp simd
        for (std::size_t x = 0; x < width; ++x) {
          const float dr = re[x] - re2[x], di = im[x] - im2[x];
          re[x] += re2[x];
          im[x] += im2[x];
          re2[x] = c * dr - s * di;
          im2[x] = c * di + s * dr;
        }
      }
    }
  }
}

// Its inverse times the length: decimation in time (Cooley and Tukey 1965).
void KernelRatio::backward(Plane& plane, const Roots& roots, std::size_t width) noexcept {
  const std::size_t length = roots.length;
  for (std::size_t half = 1, step = length / 2; half < length; half *= 2, step /= 2) {
    for (std::size_t block = 0; block < length; block += 2 * half) {
      for (std::size_t j = 0; j < half; ++j) {
        float* const re = plane.re.data() + (block + j) * width;
        float* const im = plane.im.data() + (block + j) * width;
        float* const re2 = re + half * width;
        float* const im2 = im + half * width;
        const float c = roots.cosine[j * step], s = roots.sine[j * step];
#pragma omp simd
        for (std::size_t x = 0; x < width; ++x) {
          const float tr = c * re2[x] - s * im2[x], ti = c * im2[x] + s * re2[x];
          re2[x] = re[x] - tr;
          im2[x] = im[x] - ti;
          re[x] += tr;
          im[x] += ti;
        }
      }
    }
  }
}

// `from` has `rows` rows of `columns`, `to` the columns as rows.
void KernelRatio::turn(const Plane& from, Plane& to, std::size_t rows, std::size_t columns) noexcept {
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      to.re[column * rows + row] = from.re[row * columns + column];
      to.im[column * rows + row] = from.im[row * columns + column];
    }
  }
}

// The rest of the plane is empty.
void KernelRatio::transform(std::span<const float> normal) noexcept {
  const std::size_t height = along_y_.length;
  const auto used = static_cast<std::ptrdiff_t>(columns_ * height);
  std::copy(normal.begin(), normal.end(), lines_.re.begin());
  std::fill(lines_.re.begin() + static_cast<std::ptrdiff_t>(normal.size()), lines_.re.begin() + used, 0.0F);
  std::fill_n(lines_.im.begin(), used, 0.0F);
  forward(lines_, along_y_, columns_);
  turn(lines_, spectrum_, height, columns_);
  for (auto* part : {&spectrum_.re, &spectrum_.im}) std::fill(part->begin() + used, part->end(), 0.0F);
  forward(spectrum_, along_x_, height);
}

// Only of the grid's own columns.
void KernelRatio::transform_back() noexcept {
  backward(product_, along_x_, along_y_.length);
  turn(product_, lines_, columns_, along_y_.length);
  backward(lines_, along_y_, columns_);
}

// Two real results at a time, as real and imaginary part.
void KernelRatio::apply(std::span<const float> normal, const Felt& out) noexcept {
  transform(normal);
  for (std::size_t i = 0; i < xx_.size(); ++i) {
    const float re = spectrum_.re[i], im = spectrum_.im[i];
    product_.re[i] = xx_[i] * re - yy_[i] * im;
    product_.im[i] = xx_[i] * im + yy_[i] * re;
  }
  transform_back();
  std::copy_n(lines_.re.begin(), out.xx.size(), out.xx.begin());
  std::copy_n(lines_.im.begin(), out.yy.size(), out.yy.begin());
  for (std::size_t i = 0; i < xy_.size(); ++i) {
    product_.re[i] = xy_[i] * spectrum_.re[i];
    product_.im[i] = xy_[i] * spectrum_.im[i];
  }
  transform_back();
  std::copy_n(lines_.re.begin(), out.xy.size(), out.xy.begin());
}

}  // namespace slipd
