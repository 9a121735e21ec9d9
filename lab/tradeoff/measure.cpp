#include "lab/tradeoff/measure.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/chain/setup/method_table.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "lab/tradeoff/over_time.hpp"
#include "paper/method/svd_knn.hpp"
#include "paper/train.hpp"
#include "paper/validation/tradeoff.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kPadMetres = 0.016;
constexpr double kTrainedNoise = 0.01;  // relative
constexpr double kMostAnswered = 0.8;   // a method that gives fewer margins is not on the front
constexpr std::size_t kGraspsPerContact = 5;

TaxelLayout layout_of(const std::string& name) {
  if (name == "wrench") return TaxelLayout::wrench(kPadMetres);
  const std::size_t side = std::stoul(name);
  // Commercial fingertips of 4 x 4 taxels have a pitch of 4.7 mm.
  return TaxelLayout::grid(side, side, side == 4 ? 0.0047 : kPadMetres / static_cast<double>(side));
}

Scene scene_of(double noise) {
  Scene scene;
  scene.objects = paper_objects();
  scene.offset_m = 0.002;
  scene.noise = noise;
  return scene;
}

// Each is trained once per layout, at kTrainedNoise, and tested with every noise.
std::vector<std::unique_ptr<SlipMethod>> trained_methods(const TaxelLayout& layout,
                                                         const TradeoffOptions& options) {
  ModelSetup setup{.layout = layout, .scene = scene_of(kTrainedNoise), .size = {}, .seed = options.seed};
  std::vector<std::unique_ptr<SlipMethod>> methods;
  // Omits ranks above the number of taxels.
  const auto add = [&](const std::vector<int>& ranks, bool twice) {
    std::vector<ModelData> models;
    try {
      models = train_ranks(setup, ranks, options.threads);
    } catch (const ModelError&) {
      return;
    }
    for (auto& data : models) {
      const auto model = std::make_shared<const Model>(std::move(data));
      methods.push_back(std::make_unique<SvdKnn>(model));
      if (twice) methods.push_back(std::make_unique<SvdKnn>(model, Precision::double_precision));
    }
  };
  const int most = static_cast<int>(std::min<std::size_t>(20, layout.size()));
  setup.size = kUnseenFirst;
  add({3, 8}, false);
  add({most}, true);
  setup.size = {};
  setup.view = View::rings;
  add({2, 5}, false);
  add({3}, true);
  for (const int rings : {8, 4}) {
    setup.rings = rings;
    add({3}, false);
  }
  setup.rings = Rings::kCount;
  for (const int neighbours : {32}) {
    setup.neighbours = neighbours;
    add({3}, false);
  }
  return methods;
}

// None for a sensor of one taxel, whose single frames give no margin.
std::vector<std::unique_ptr<SlipMethod>> methods_for(const TaxelLayout& layout,
                                                     const TradeoffOptions& options) {
  std::vector<std::unique_ptr<SlipMethod>> methods;
  if (layout.size() < 2) return methods;
  methods.push_back(std::make_unique<Moments>(layout));
  if (blocks_pay(layout, scene_of(0)))
    methods.push_back(std::make_unique<BlockFit>(layout, expected_friction(scene_of(0))));
  methods.push_back(make_fit(layout, expected_friction(scene_of(0))));
  if (options.models) {
    for (auto& method : trained_methods(layout, options)) methods.push_back(std::move(method));
  }
  return methods;
}

std::vector<Line> lines_of(const std::string& name, const TaxelLayout& layout, const Noise& noise,
                           const std::vector<std::unique_ptr<SlipMethod>>& methods,
                           const TradeoffOptions& options) {
  const Scene scene = scene_of(noise.half_width);
  const std::uint64_t seed = options.seed + 1;
  std::vector<Line> lines;
  if (!methods.empty()) {
    const CramerRaoBound limit =
        mean_cramer_rao_bound(layout, scene, noise.kind, noise.half_width, options.contacts, seed);
    for (const auto& method : methods) {
      lines.push_back(
          {name, noise, "",
           measure_tradeoff(layout, scene, *method, noise.kind, noise.half_width, options.contacts, seed),
           limit, false});
    }
    mark_front(lines);
  }
  if (layout.size() <= kFewTaxels) {
    const std::size_t grasps = std::max<std::size_t>(1, options.contacts / kGraspsPerContact);
    for (auto& line : measure_over_time(name, layout, scene, noise, grasps, seed))
      lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

void mark_front(std::vector<Line>& lines) {
  for (auto& line : lines) {
    line.front = line.row.answered >= kMostAnswered &&
                 std::none_of(lines.begin(), lines.end(), [&](const Line& other) {
                   return other.row.answered >= kMostAnswered && other.row.p50_us < line.row.p50_us &&
                          other.row.mean_error < line.row.mean_error;
                 });
  }
}

std::vector<Line> measure_tradeoffs(const TradeoffOptions& options, const Tell& tell) {
  std::vector<Line> all;
  const double steps = static_cast<double>(options.layouts.size() * (options.noises.size() + 1));
  double step = 0;
  for (std::size_t at = 0; at < options.layouts.size(); ++at) {
    const std::string& name = options.layouts[at];
    const TaxelLayout layout = layout_of(name);
    tell(step++ / steps, name.c_str());
    std::vector<std::unique_ptr<SlipMethod>> methods;
    for (std::size_t which = 0; which < options.noises.size(); ++which) {
      tell(step++ / steps, name.c_str());
      const std::size_t unit = at * options.noises.size() + which;
      if (!options.shard.has(unit)) continue;
      if (methods.empty()) methods = methods_for(layout, options);
      for (auto& line : lines_of(name, layout, options.noises[which], methods, options)) {
        line.unit = unit;
        all.push_back(std::move(line));
      }
    }
  }
  return all;
}

}  // namespace lab
