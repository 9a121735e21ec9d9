// Error against run time: what each method that a sensor could use is worth and costs, measured on contacts
// of its scene that nothing was trained on. From this `auto` chooses. Set-up threads and tools; takes tens of
// milliseconds.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/contact/imprint.hpp"
#include "core/estimate/chain.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/trial_frames.hpp"
#include "core/model/work_precision.hpp"

namespace slipd {

// Contacts drawn from the scene, Gamma uniform in (0, 1), loads rising, each frame for itself, exact taxel
// averages; under the scene's skin, if it has a depth. `noise`: the half-width as a fraction. The same seed
// draws the same contacts; to make their frames takes longer than most methods do, so that several at once
// are measured sooner.
std::vector<TradeoffRow> measure_tradeoff(const TaxelLayout& layout, const Scene& scene,
                                          std::span<SlipMethod* const> methods, NoiseKind kind, double noise,
                                          std::size_t contacts, std::uint64_t seed);
// The same of contacts whose shape is `imprint`'s, under its skin, the ellipse turned at random.
// closing_frames: that the methods get before the loaded one, while the normal force rises evenly; their
// noise is as large as that of the loaded frame.
std::vector<TradeoffRow> measure_imprint_tradeoff(const TaxelLayout& layout, const Scene& scene,
                                                  const contact::Imprint& imprint,
                                                  std::span<SlipMethod* const> methods, NoiseKind kind,
                                                  double noise, std::size_t contacts, std::uint64_t seed,
                                                  int closing_frames = 0);
TradeoffRow measure_tradeoff(const TaxelLayout& layout, const Scene& scene, SlipMethod& method,
                             NoiseKind kind, double noise, std::size_t contacts, std::uint64_t seed);

// Each method that a sensor of this model could use: moments, fit, and SvdKnn at each of `models`, which are
// of one scene, the first of them in double precision as well. On relative noise as strong as the scene says.
WorkPrecision measure_work_precision(const std::vector<std::shared_ptr<const Model>>& models,
                                     std::size_t contacts, std::uint64_t seed);

// What a method that needs no training is worth on a sensor's scene. Without rows for others, and for few
// taxels, of which no single frame determines its margin.
WorkPrecision measure_work_precision(const ChainSetup& setup, Method method);

// Whether `block-fit` takes less time than `fit` on a scene worth telling: contacts are so many taxels wide,
// on average, that blocks hold several. `scene` has objects.
bool blocks_pay(const TaxelLayout& layout, const Scene& scene);

std::string processor_name();  // of this machine, as its kernel says

// The friction that a scene's objects may have; that of docs/theory.md §9.1 for a scene without objects.
Range expected_friction(const Scene& scene);

// The least mean error among those within the budget, the fastest if none is. `rows` is not empty.
std::size_t choose(std::span<const TradeoffRow> rows, double budget_us);

}  // namespace slipd
