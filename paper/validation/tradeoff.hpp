// Error against run time: what each method that a sensor could use is worth and costs, measured on contacts
// of its scene that nothing was trained on. From this `auto` chooses. Set-up threads and tools; takes tens of
// milliseconds.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/contact/contact_field.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/work_precision.hpp"
#include "paper/model/model.hpp"
#include "paper/validation/trial_frames.hpp"

namespace slipd {

// Contacts drawn from the scene, Gamma uniform in (0, 1), loads rising, each frame for itself, exact taxel
// averages; under the scene's skin, if it has a depth. `noise`: the half-width as a fraction. The same seed
// draws the same contacts; to make their frames takes longer than most methods do, so that several at once
// are measured sooner.
std::vector<TradeoffRow> measure_tradeoff(const TaxelLayout& layout, const Scene& scene,
                                          std::span<SlipMethod* const> methods, NoiseKind kind, double noise,
                                          std::size_t contacts, std::uint64_t seed);
// The same of contacts whose shape is `geometry`'s, under its skin, the ellipse turned at random.
// closing_frames: that the methods get before the loaded one, while the normal force rises evenly; their
// noise is as large as that of the loaded frame.
std::vector<TradeoffRow> measure_shape_tradeoff(const TaxelLayout& layout, const Scene& scene,
                                                const contact::ContactGeometry& geometry,
                                                std::span<SlipMethod* const> methods, NoiseKind kind,
                                                double noise, std::size_t contacts, std::uint64_t seed,
                                                int closing_frames = 0);
TradeoffRow measure_tradeoff(const TaxelLayout& layout, const Scene& scene, SlipMethod& method,
                             NoiseKind kind, double noise, std::size_t contacts, std::uint64_t seed);

// Each method that a sensor of this model could use: moments, fit, and SvdKnn at each of `models`, which are
// of one scene, the first of them in double precision as well. On relative noise as strong as the scene says.
WorkPrecision measure_work_precision(const std::vector<std::shared_ptr<const Model>>& models,
                                     std::size_t contacts, std::uint64_t seed);

std::string processor_name();  // of this machine, as its kernel says

}  // namespace slipd
