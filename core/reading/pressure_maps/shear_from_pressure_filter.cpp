#include "core/reading/pressure_maps/shear_from_pressure_filter.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/numeric/norm.hpp"

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

// A wave number times the depth. odd: for kernels that are odd in it. per_k: 1/k; 0 at 0.
struct Wave {
  double kx, ky, odd_kx, odd_ky, per_k;
};

// The length of the transforms that a kernel is found by. Longer: set-up takes time. Shorter: the kernel's
// images are read as shear.
constexpr std::size_t wider(std::size_t length) noexcept {
  constexpr std::size_t kLong = 256;
  return std::min(4 * length, std::max(2 * length, kLong));
}

}  // namespace

ShearFromPressureFilter::Roots::Roots(std::size_t n) : length(n), cosine(n / 2), sine(n / 2) {
  for (std::size_t j = 0; j < n / 2; ++j) {
    const double angle_rad = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n);
    cosine[j] = static_cast<float>(std::cos(angle_rad));
    sine[j] = static_cast<float>(std::sin(angle_rad));
  }
}

ShearFromPressureFilter::ShearFromPressureFilter(const TaxelLayout::Grid& grid, double depth_m,
                                                 double least_sensed)
    : columns_(grid.columns),
      along_x_(std::bit_ceil(2 * grid.columns)),
      along_y_(std::bit_ceil(2 * grid.rows)) {
  const std::size_t size = along_x_.length * along_y_.length;
  spectrum_.resize(size);
  product_.resize(size);
  lines_.resize(size);
  const double nominal_sides = depth_m / grid.pitch_m;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    nodes_[i] = kernels_at(nominal_sides * std::exp(kReach * (static_cast<double>(i) - 1)), nominal_sides,
                           least_sensed);
  now_ = nodes_[1];
  double squares = 0, pressing = 0;
  for (std::size_t i = 0; i < size; ++i) {
    squares += 0.5 * (now_.xx[i] * now_.xx[i] + 2 * now_.xy[i] * now_.xy[i] + now_.yy[i] * now_.yy[i]);
    pressing += 0.5 * (now_.press_re[i] * now_.press_re[i] + now_.press_im[i] * now_.press_im[i]);
  }
  noise_gain_ = static_cast<double>(size) * squares;
  pressing_gain_ = static_cast<double>(size) * pressing;
}

// The ratio's kernel falls only with the third power of the distance. So it is found on a plane
// wider than the transforms, of which the distances between two taxels are kept: the filter
// reaches from each taxel to each other one, and not around.
ShearFromPressureFilter::Kernels ShearFromPressureFilter::kernels_at(double depth_sides, double nominal_sides,
                                                                     double least_sensed) {
  const std::size_t width = along_x_.length, height = along_y_.length;
  const Roots wide_x(wider(width)), wide_y(wider(height));
  Plane wide, turned;
  wide.resize(wide_x.length * wide_y.length);
  turned.resize(wide.re.size());
  const auto wave_number = [&](std::size_t i, std::size_t length) {  // times the depth
    return 2 * std::numbers::pi * frequency_at(i, length) / static_cast<double>(length) * depth_sides;
  };
  // Leaves in spectrum_ the sum of a kernel and i times another one; `ratio` gives both, times 1 + k d.
  const auto keep = [&](const auto& ratio) {
    for (std::size_t u = 0; u < wide_x.length; ++u) {
      const double kx = wave_number(u, wide_x.length);
      for (std::size_t v = 0; v < wide_y.length; ++v) {
        const double ky = wave_number(v, wide_y.length), k = norm(kx, ky);
        const double nominal = depth_sides > 0 ? k * nominal_sides / depth_sides : 0;
        const double sensed = (1 + nominal) * std::exp(-nominal) < least_sensed ? 0 : 1 / (1 + k);
        // The highest frequency of an even length has both signs.
        const std::complex<double> both =
            ratio({kx, ky, u == 1 ? 0 : kx, v == 1 ? 0 : ky, k > 0 ? 1 / k : 0});
        wide.re[u * wide_y.length + v] = static_cast<float>(sensed * both.real());
        wide.im[u * wide_y.length + v] = static_cast<float>(sensed * both.imag());
      }
    }
    backward(wide, wide_x, wide_y.length);
    turn(wide, turned, wide_x.length, wide_y.length);
    backward(turned, wide_y, wide_x.length);
    const auto kept = [](std::size_t i, std::size_t length) {
      return i < length / 2 ? i : wider(length) - length + i;
    };
    const auto scale = 1 / static_cast<float>(wide.re.size() * width * height);
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
  using Both = std::complex<double>;
  Kernels out;
  keep([](const Wave& at) { return Both(1 - at.kx * at.kx * at.per_k, 1 - at.ky * at.ky * at.per_k); });
  out.xx = spectrum_.re;
  out.yy = spectrum_.im;
  keep([](const Wave& at) { return Both(-at.odd_kx * at.odd_ky * at.per_k, 0); });
  out.xy = spectrum_.re;
  keep([](const Wave& at) { return Both(at.odd_ky, -at.odd_kx); });
  out.press_re = spectrum_.re;
  out.press_im = spectrum_.im;
  return out;
}

// A parabola through the three depths.
void ShearFromPressureFilter::set_depth(double log) noexcept {
  const double at = std::clamp(log / kReach, -1.0, 1.0);
  const auto low = static_cast<float>(0.5 * at * (at - 1)), middle = static_cast<float>(1 - at * at),
             high = static_cast<float>(0.5 * at * (at + 1));
  for (std::vector<float> Kernels::*part :
       {&Kernels::xx, &Kernels::xy, &Kernels::yy, &Kernels::press_re, &Kernels::press_im}) {
    const std::vector<float>&a = nodes_[0].*part, &b = nodes_[1].*part, &c = nodes_[2].*part;
    std::vector<float>& out = now_.*part;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = low * a[i] + middle * b[i] + high * c[i];
  }
}

std::size_t ShearFromPressureFilter::memory_bytes() const noexcept {
  return sizeof(float) * (std::size_t{5} * 4 * now_.xx.size() + 4 * spectrum_.re.size() +
                          2 * lines_.re.size() + 2 * along_x_.cosine.size() + 2 * along_y_.cosine.size());
}

// Decimation in frequency (Gentleman and Sande 1966) of `width` transforms side by side.
void ShearFromPressureFilter::forward(Plane& plane, const Roots& roots, std::size_t width) noexcept {
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
void ShearFromPressureFilter::backward(Plane& plane, const Roots& roots, std::size_t width) noexcept {
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
void ShearFromPressureFilter::turn(const Plane& from, Plane& to, std::size_t rows,
                                   std::size_t columns) noexcept {
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      to.re[column * rows + row] = from.re[row * columns + column];
      to.im[column * rows + row] = from.im[row * columns + column];
    }
  }
}

// The rest of the plane is empty.
void ShearFromPressureFilter::transform(std::span<const float> normal) noexcept {
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
void ShearFromPressureFilter::transform_back() noexcept {
  backward(product_, along_x_, along_y_.length);
  turn(product_, lines_, columns_, along_y_.length);
  backward(lines_, along_y_, columns_);
}

// Of what was transformed last. Two real results at a time, as real and imaginary part.
void ShearFromPressureFilter::filter(const std::vector<float>& kernel_re, const std::vector<float>& kernel_im,
                                     std::span<float> out_re, std::span<float> out_im) noexcept {
  for (std::size_t i = 0; i < kernel_re.size(); ++i) {
    const float re = spectrum_.re[i], im = spectrum_.im[i];
    product_.re[i] = kernel_re[i] * re - kernel_im[i] * im;
    product_.im[i] = kernel_re[i] * im + kernel_im[i] * re;
  }
  transform_back();
  std::copy_n(lines_.re.begin(), out_re.size(), out_re.begin());
  std::copy_n(lines_.im.begin(), out_im.size(), out_im.begin());
}

void ShearFromPressureFilter::apply(std::span<const float> normal, const Sensed& out) noexcept {
  transform(normal);
  filter(now_.xx, now_.yy, out.xx, out.yy);
  for (std::size_t i = 0; i < now_.xy.size(); ++i) {
    product_.re[i] = now_.xy[i] * spectrum_.re[i];
    product_.im[i] = now_.xy[i] * spectrum_.im[i];
  }
  transform_back();
  std::copy_n(lines_.re.begin(), out.xy.size(), out.xy.begin());
  filter(now_.press_re, now_.press_im, out.nx, out.ny);
}

void ShearFromPressureFilter::press(std::span<const float> normal, std::span<float> x,
                                    std::span<float> y) noexcept {
  transform(normal);
  filter(now_.press_re, now_.press_im, x, y);
}

}  // namespace slipd
