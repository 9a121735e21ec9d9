#include "paper/method/svd_knn.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "core/simd/instruction_sets.hpp"
#include "paper/dataset/alpha_kernels.hpp"
#include "paper/dataset/ring_columns.hpp"
#include "paper/method/knn.hpp"

namespace slipd {
namespace {

// Further than this many times what all but 1 in 1000 of the unseen contacts kept, a frame is none of the
// scene's.
constexpr float kBeyond = 1.5F;

constexpr double kContradicted = 2.5;         // standard deviations
constexpr double kFrameShare = 0.8;           // of the moments' own deviation
constexpr double kTellsFriction = 0.2;        // sigma of the margin over 1 - margin
constexpr double kLeastFrictionSigma = 0.05;  // relative

}  // namespace

SvdKnn::SvdKnn(std::shared_ptr<const Model> model, Precision precision)
    : model_(std::move(model)),
      query_(model_->neighbours(), searched(model_->setup())),
      moments_(model_->setup().layout),
      alpha_(std::max(model_->setup().layout.size(), TaxelView::kLanes)),
      point_(model_->rank()),
      point_double_(model_->rank()),
      precision_(precision) {}

MethodSettings SvdKnn::settings() const noexcept {
  const ModelSetup& setup = model_->setup();
  const ModelData& data = model_->data();
  const bool rings = setup.view == View::rings;
  // Points twice: the model's and the search tree's, which has an index beside each.
  const std::size_t numbers = data.basis.size() + 2 * data.coordinates.size() + data.gamma.size() +
                              data.friction.size() + 2 * data.gamma.size() + alpha_.size();
  return {.rank = static_cast<int>(point_.size()),
          .rings = rings ? setup.rings : 0,
          .neighbours = static_cast<int>(searched(setup)),
          .precision = precision_,
          .memory_bytes = sizeof(*this) + sizeof(float) * numbers + 2 * sizeof(double) * setup.layout.size()};
}

template <>
std::vector<float>& SvdKnn::sums() noexcept {
  return point_;
}
template <>
std::vector<double>& SvdKnn::sums() noexcept {
  return point_double_;
}

// By the loops where the basis is as wide as they take and single precision will do; else coordinate by
// coordinate.
template <class Real>
void SvdKnn::project_angles(const ContactPatch& patch) noexcept {
  const float* basis = model_->data().basis.data();
  const std::size_t rank = point_.size();
  if (std::is_same_v<Real, float> && rank % AlphaKernels::kTogether == 0) {
    for (std::size_t k = 0; k < rank; k += AlphaKernels::kTogether)
      best_kernels<AlphaKernels>().project(alpha_.data(), patch.runs, basis + k, rank, point_.data() + k);
    return;
  }
  std::vector<Real>& sum = sums<Real>();
  std::fill(sum.begin(), sum.end(), Real(0));
  patch.for_each_inside([&](std::uint32_t i) {
    for (std::size_t k = 0; k < rank; ++k) sum[k] += Real(alpha_[i]) * Real(basis[i * rank + k]);
  });
  std::transform(sum.begin(), sum.end(), point_.begin(), [](Real z) { return static_cast<float>(z); });
}

template <class Real>
bool SvdKnn::project(const ContactPatch& patch, float& noise) noexcept {
  const AlphaMask mask{.least_pa = patch.peak_pa * mask_fraction(model_->setup().scene.noise),
                       .along_x = static_cast<float>(patch.direction_x),
                       .along_y = static_cast<float>(patch.direction_y)};
  const AngleSums angles = best_kernels<AlphaKernels>().angles(patch.taxels, patch.runs, mask, alpha_.data());
  if (angles.taken == 0) return false;
  project_angles<Real>(patch);
  const auto taken = static_cast<float>(angles.taken), squares = static_cast<float>(angles.squares);
  // d(alpha) = dq/p at most, and each basis has norm 1: the mean over the taxels is what a coordinate sees.
  noise = static_cast<float>(patch.noise_shear_pa) *
          std::sqrt(static_cast<float>(angles.inverse_squares_per_pa2) / taken);
  float kept = 0;
  for (const float z : point_) kept += z * z;
  const float noise_squares = noise * noise * taken;
  return squares - kept <= kBeyond * model_->data().errors.residual_limit * squares + 2 * noise_squares;
}

template <class Real>
bool SvdKnn::project_rings(const ContactPatch& patch, const Rings& all, float& noise) noexcept {
  const TaxelLayout& layout = model_->setup().layout;
  const std::size_t count = model_->setup().rows();
  const Rings rings = merged(all, count);
  const auto angles = ring_angles(rings, count);
  const float* basis = model_->data().basis.data();
  const std::size_t rank = point_.size();
  std::vector<Real>& sum = sums<Real>();
  std::fill(sum.begin(), sum.end(), Real(0));
  float squares = 0, noise_squares = 0;
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t k = 0; k < rank; ++k) sum[k] += Real(angles[j]) * Real(basis[j * rank + k]);
    squares += angles[j] * angles[j];
    if (!(rings.normal_n[j] > 0)) continue;
    const double sigma = ring_weight(j, count) * patch.noise_shear_pa * layout.area_m2() *
                         std::sqrt(rings.taxels[j]) / rings.normal_n[j];
    noise_squares += static_cast<float>(sigma * sigma);
  }
  noise = std::sqrt(noise_squares / static_cast<float>(count));
  std::transform(sum.begin(), sum.end(), point_.begin(), [](Real z) { return static_cast<float>(z); });
  float kept = 0;
  for (const float z : point_) kept += z * z;
  return squares > 0 &&
         squares - kept <= kBeyond * model_->data().errors.residual_limit * squares + 4 * noise_squares;
}

Reading SvdKnn::estimate(const Frame&, const ContactPatch& patch) noexcept {
  Reading out;
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
  const Rings sums = sum_rings(patch, model_->setup().layout);
  const Reading shape = moments_.estimate(patch, sums);
  out.moments = shape.moments;
  out.moments_sigma = shape.moments_sigma;
  out.moments_common_sigma = shape.moments_common_sigma;
  float noise = 0;
  const bool rings = model_->setup().view == View::rings;
  if (rings && patch.cut) return out;
  const bool twice = precision_ == Precision::double_precision;
  const bool known =
      rings ? (twice ? project_rings<double>(patch, sums, noise) : project_rings<float>(patch, sums, noise))
            : (twice ? project<double>(patch, noise) : project<float>(patch, noise));
  if (!known) return out;
  const ModelData& data = model_->data();
  const KnnResult answer = rings
                               ? plane_answer_of(query_, point_, data.coordinates, data.gamma, data.friction)
                               : answer_of(query_, point_, data.gamma, data.friction);
  const float all_noise = noise * std::sqrt(static_cast<float>(point_.size()));
  if (!answer.known || answer.distance > kBeyond * model_->data().errors.distance_limit + 3 * all_noise)
    return out;

  out.gamma = answer.gamma;
  // What unseen contacts were off by, and what noise adds: gamma changes by its spread over the neighbours'
  // reach.
  const double by_noise = answer.reach > 0 ? answer.spread * std::min(noise / answer.reach, 10.0F) : 0.0F;
  out.common_sigma = model_->gamma_error(answer.spread);
  out.sigma = std::hypot(out.common_sigma, by_noise);
  // On rings noise moves the frame itself, its place and its size, as much as it moves the moments.
  if (rings) out.sigma = std::hypot(out.sigma, kFrameShare * shape.sigma);

  // Friction from the margin, where the load is heavy enough for that: a margin near 1 says little of it,
  // and the neighbours' own friction is spread too wide to be remembered.
  const double load = 1 - out.gamma;
  out.friction = load > 0 ? patch.shear_n / patch.normal_n / load : static_cast<double>(answer.friction);
  out.friction_sigma = out.sigma < kTellsFriction * load
                           ? out.friction * std::hypot(out.sigma / load, kLeastFrictionSigma)
                           : std::numeric_limits<double>::infinity();
  // Neighbours far apart in friction may lie side by side where the load is light: an answer that the shape
  // itself contradicts is none.
  out.in_model = shape.in_model &&
                 std::fabs(out.gamma - shape.gamma) < kContradicted * std::hypot(out.sigma, shape.sigma);
  return out;
}

std::unique_ptr<SlipMethod> Model::make_method() const {
  return std::make_unique<SvdKnn>(shared_from_this());
}

}  // namespace slipd
