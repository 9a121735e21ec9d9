#include "core/contact/subsurface/rigid_base.hpp"

#include <Eigen/QR>
#include <cmath>

#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

// Of images, over the layer's thickness. The first is that of short waves.
constexpr std::array<double, kLayerImages> kDepths{1, 1.5, 2.1, 2.82, 3.684, 4.7208};

// Wave numbers over which the images are fitted, times the layer's thickness.
constexpr Eigen::Index kWaves = 200;
constexpr double kMostWave = 16;

// Least squares of the columns `terms` to `wanted`, with weights that even out the greatest errors.
Eigen::VectorXd fitted(const Eigen::VectorXd& waves, const Eigen::MatrixXd& terms,
                       const Eigen::VectorXd& wanted) {
  // Holds shares down to about 50, so that errors of the half space's integrals do not grow.
  constexpr double kRidge = 3e-6;
  constexpr int kRounds = 3;
  const double step = kMostWave / kWaves;
  Eigen::VectorXd weights = (step * (0.3 + waves.array())).sqrt(), shares;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(terms.rows() + terms.cols(), terms.cols());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(system.rows());
  system.bottomRows(terms.cols()).diagonal().setConstant(kRidge);
  for (int round = 0; round < kRounds; ++round) {
    system.topRows(terms.rows()) = weights.asDiagonal() * terms;
    right.head(terms.rows()) = weights.cwiseProduct(wanted);
    shares = system.colPivHouseholderQr().solve(right);
    const Eigen::ArrayXd error = (terms * shares - wanted).array().abs();
    weights.array() *= (0.05 + error / error.maxCoeff()).pow(0.25);
  }
  return shares;
}

[[gnu::always_inline]] inline void add(const LayerImage& image, const double* from, double* to,
                                       std::size_t n) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < n; ++i) {
    const double nn = from[i], nx = from[n + i], ny = from[2 * n + i], xx = from[3 * n + i],
                 xy = from[4 * n + i], yy = from[5 * n + i], mean = (nn + xx + yy) / 3;
    to[i] += image.normal * nn + image.normal_mean * mean;
    to[n + i] += image.normal_of_tangential * nx;
    to[2 * n + i] += image.normal_of_tangential * ny;
    to[3 * n + i] += image.tangential * xx + image.tangential_mean * mean;
    to[4 * n + i] += image.tangential * xy;
    to[5 * n + i] += image.tangential * yy + image.tangential_mean * mean;
    to[6 * n + i] += image.tangential_of_normal * nx;
    to[7 * n + i] += image.tangential_of_normal * ny;
  }
}

// As in core/simd/inlined_loops.hpp.
struct LayerKernels {
  void (*add)(const LayerImage&, const double*, double*, std::size_t) noexcept;
  static const LayerKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void add_on_baseline(const LayerImage& image, const double* from, double* to, std::size_t count) noexcept {
  add(image, from, to, count);
}
const LayerKernels LayerKernels::baseline{add_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void add_on_avx2(const LayerImage& image, const double* from, double* to,
                                             std::size_t count) noexcept {
  add(image, from, to, count);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void add_on_avx512(const LayerImage& image, const double* from,
                                                                double* to, std::size_t count) noexcept {
  add(image, from, to, count);
}
const LayerKernels LayerKernels::avx2{add_on_avx2};
const LayerKernels LayerKernels::avx512{add_on_avx512};
#endif

}  // namespace

// The numerators and the denominator are times e^(-2 kh).
LayerTransfer layer_transfer(double kh, double poisson) noexcept {
  const double fade = std::exp(-kh), ch = 0.5 * (1 + fade * fade), sh = 0.5 * (1 - fade * fade);
  const double m = 2 * (1 - poisson), l = 1 - 2 * poisson;
  const double share = m * fade / ((kh * kh + l * l) * fade * fade + (3 - 4 * poisson) * ch * ch);
  return {.normal = share * (m * ch + kh * sh),
          .normal_of_tangential = share * (kh * ch + l * sh),
          .tangential_of_normal = share * (kh * ch - l * sh),
          .along = share * (m * ch - kh * sh),
          .across = fade / ch};
}

std::array<LayerImage, kLayerImages> layer_images(double poisson) {
  constexpr auto kImages = static_cast<Eigen::Index>(kLayerImages);
  Eigen::VectorXd waves(kWaves), normal(kWaves), of_tangential(kWaves), of_normal(kWaves), across(kWaves),
      apart(kWaves);
  Eigen::MatrixXd even(kWaves, kImages), odd(kWaves, kImages), both(kWaves, 2 * kImages);
  for (Eigen::Index i = 0; i < kWaves; ++i) {
    const double k = waves[i] = kMostWave / kWaves * (static_cast<double>(i) + 0.5);
    const LayerTransfer wanted = layer_transfer(k, poisson);
    normal[i] = wanted.normal;
    of_tangential[i] = wanted.normal_of_tangential;
    of_normal[i] = wanted.tangential_of_normal;
    across[i] = wanted.across;
    apart[i] = wanted.across - wanted.along;
    for (Eigen::Index j = 0; j < kImages; ++j) {
      const double kz = k * kDepths[static_cast<std::size_t>(j)];
      even(i, j) = std::exp(-kz);
      odd(i, j) = kz * std::exp(-kz);
    }
  }
  both << even, odd;
  const Eigen::VectorXd n = fitted(waves, both, normal), nt = fitted(waves, odd, of_tangential),
                        tn = fitted(waves, odd, of_normal), t = fitted(waves, even, across),
                        apart_by = fitted(waves, odd, apart);
  std::array<LayerImage, kLayerImages> images;
  for (std::size_t i = 0; i < kLayerImages; ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    images[i] = {.depth = kDepths[i],
                 .normal = n[kImages + j],
                 .normal_mean = n[j] - n[kImages + j],
                 .normal_of_tangential = nt[j],
                 .tangential_of_normal = tn[j],
                 .tangential = apart_by[j],
                 .tangential_mean = t[j] - apart_by[j]};
  }
  best_kernels<LayerKernels>();  // not first within a fit
  return images;
}

void add_image(const LayerImage& image, const double* from, double* to, std::size_t count) noexcept {
  best_kernels<LayerKernels>().add(image, from, to, count);
}

}  // namespace slipd::contact
