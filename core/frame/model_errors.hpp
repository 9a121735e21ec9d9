// What a real skin and a real contact differ from their models by. Checked with `slipd-lab histories --grasps
// 400` and on recordings of real sensors.
#pragma once

namespace slipd {

// What the shear of a real skin deviates from the model: ring by ring, in its forces, moments and torque, in
// the friction that it shows, and what few domes or maps miss of it; relative, standard deviation, 0.005 …
// 0.1. Too small: real skins are refused, pure pulls get torques, and the model's error refutes the right
// friction. Too large: other histories pass, small torques are left out of margins, and frictions are not
// distinguished.
inline constexpr double kUnevenShare = 0.02;

// Standard deviation of Gamma, or of friction over a grasp, relative, of a contact that is not quite as its
// model: on few taxels, on a skin that is uneven by kUnevenShare, or of another shape, which maps may know
// better; 0.005 … 0.1. Too small: sigma is less than the error, and two methods run for one margin. Too
// large: such frames are wasted, and ellipses get an imprecise margin.
inline constexpr double kModelSigma = 0.03;

// Standard deviation of Gamma, also relative, of a contact as far from its model as is answered: at the
// greatest tilt, ellipticity or kurtosis, and at least twice as wide as a skin on a rigid base is thick; 0 …
// 0.3. Too small: sigma is less than the error on such contacts. Too large: it is more.
inline constexpr double kFarSigma = 0.12;

// What is left on a perfect sensor, and what gains and rounding of taxels leave of one without noise: floor
// of the sigmas of Gamma, of |Q|/P and of the ratio of moments, and of a taxel's noise, of the peak; 1e-6 …
// 0.01 (the mean error of `fit` on 100 x 100 taxels with 1 % of relative noise is 0.0002). Too small: a frame
// without noise gives exact margins, and normal equations that are singular. Too large: sharp frames are
// wasted.
inline constexpr double kExactShare = 7e-4;

}  // namespace slipd
