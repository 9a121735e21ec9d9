// A skin bonded to a rigid base, in which the taxels are: an elastic layer with a free surface, as thick as
// they are deep. What reaches the base has a closed form in Fourier space, but not in space. Here it is a sum
// of what is sensed at several depths of a half space, its images, which has one (docs/theory.md §5.5).
#pragma once

#include <array>
#include <cstddef>

namespace slipd::contact {

// Tractions at the base over those on the surface, for one wave number. Those that lead from a normal
// traction to a tangential one, or back, are times -i k_x/k for a traction along x.
struct LayerTransfer {
  double normal;                // of a normal traction
  double normal_of_tangential;  // as the next one at Poisson's ratio 1/2
  double tangential_of_normal;
  double along, across;  // of a tangential one, along the wave and across it
};

// kh: wave number times the layer's thickness, > 0. poisson: of the layer, 0 … 0.5. Any thread.
LayerTransfer layer_transfer(double kh, double poisson) noexcept;

// One image. Its shares of the components of SensedTensor at its depth make up those at the base; `mean`
// shares are of a third of the tensor's trace, which is the traction e^(-k z) and is sensed as such in all
// directions.
struct LayerImage {
  double depth = 1;  // over the layer's thickness
  double normal = 1, normal_mean = 0, normal_of_tangential = 1, tangential_of_normal = 1, tangential = 1,
         tangential_mean = 0;
};

// Fewer images: what is sensed is wrong by more than 4e-4 of the peak. More: contacts take longer in
// proportion.
inline constexpr std::size_t kLayerImages = 6;

// The shares by least squares, the same for every thickness. What round domes with a radius of 0.25 to 8
// thicknesses are sensed as is within 4e-4 of the greatest pressure that is sensed of them. Allocates.
std::array<LayerImage, kLayerImages> layer_images(double poisson);

// Adds an image's share. from: lists of the components nn, nx, ny, xx, xy, yy of SensedTensor; to: those of
// LayerTensor; of `count` numbers each. Any thread.
void add_image(const LayerImage& image, const double* from, double* to, std::size_t count) noexcept;

}  // namespace slipd::contact
