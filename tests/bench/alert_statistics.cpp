// alert-statistics [GRASPS [SIDE [METHOD [SEED]]]]: how many slips have an alert before them, and how many
// holds have one. Random simulated grasps in frame time, at 1 kHz, as fast as they can be computed: friction
// 0.1–0.9, 1–5 N, loads that rise to gross slip within 50 ms to 2 s, 2 % of sensor noise; and as many that
// hold with a margin of 0.5 and more through regrips and unloading. Prints a table. Fails when a slip came
// without an alert, or when more than one hold in a hundred had one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "drivers/sim/simulated_sensor.hpp"

namespace {

using namespace slipd;
using namespace std::chrono_literals;

constexpr double kPadSide_m = 0.016;
constexpr double kNoise = 0.02;  // of full scale, half-width
constexpr double kBeyond = 1.1;  // loads go this far past mu P

struct Grasp {
  sim::SensorSettings sensor;
  double friction = 0, ramp_s = 0;
};

struct TaxelRun {
  std::optional<double> alert_s, warn_due_s,
      slip_s;                            // when: the first alert, truth below warn_below, truth at 0
  std::optional<double> alert_margin;    // truth at the first alert
  std::size_t frames = 0, answered = 0;  // in contact, and with a margin
};

sim::Phase phase(double ms) {
  sim::Phase made;
  made.duration_ns = static_cast<std::int64_t>(ms * 1e6);
  return made;
}

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  Grasp slipping() {
    Grasp grasp = gripped();
    grasp.sensor.cycle.push_back(phase(1e3 * grasp.ramp_s * kBeyond));
    grasp.sensor.cycle.back().load = sim::Ramp{0, kBeyond};
    return grasp;
  }

  // Loaded and, if `busy`, regripped, unloaded, loaded again, back to the first force: the margin is never
  // below 0.5.
  Grasp holding(bool busy) {
    Grasp grasp = gripped();
    auto& cycle = grasp.sensor.cycle;
    const double normal_n = normal_n_;
    const double shear_n = within(0, 0.5) * grasp.friction * normal_n;
    const double tighter_n = normal_n * within(1.1, 1.6), rest_n = shear_n * within(0, 0.8);
    const auto shear = [&](double from, double to) {
      cycle.push_back(phase(1e3 * grasp.ramp_s));
      cycle.back().shear_n = sim::Ramp{from, to};
    };
    const auto normal = [&](double from, double to) {
      cycle.push_back(phase(within(20, 200)));
      cycle.back().normal_n = sim::Ramp{from, to};
    };
    shear(0, shear_n);
    if (busy) {
      normal(normal_n, tighter_n);
      shear(shear_n, rest_n);
      shear(rest_n, shear_n);
      normal(tighter_n, normal_n);
    }
    cycle.push_back(phase(50));
    return grasp;
  }

 private:
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Grasp gripped() {
    Grasp grasp;
    auto& sensor = grasp.sensor;
    const bool stiff = within(0, 1) < 0.5, flat = within(0, 1) < 0.5;
    sensor.object = {flat ? std::numeric_limits<double>::infinity() : within(0.01, 0.05),
                     stiff ? within(1e11, 3e11) : within(1e5, 1e7),
                     stiff ? within(0.2, 0.3) : within(0.35, 0.45)};
    sensor.offset_x_m = within(-0.002, 0.002);
    sensor.offset_y_m = within(-0.002, 0.002);
    sensor.imperfections.noise = kNoise;
    sensor.imperfections.seed = random_();
    grasp.friction = within(0.1, 0.9);
    normal_n_ = within(1, 5);
    grasp.ramp_s = 0.05 * std::pow(40, within(0, 1));
    sensor.cycle.push_back(phase(within(20, 100)));
    sensor.cycle.back().normal_n = sim::Ramp{0, normal_n_};
    sensor.cycle.back().shear_n = sim::Ramp{0, 0};
    sensor.cycle.back().friction = grasp.friction;
    sensor.cycle.push_back(phase(20));
    return grasp;
  }

  std::mt19937_64 random_;
  double normal_n_ = 0;
};

TaxelRun run(const TaxelLayout& layout, const Grasp& grasp, const ChainSetup& setup) {
  sim::SimulatedSensor sensor(layout, grasp.sensor);
  EstimatorChain chain(setup, nullptr);
  std::vector<float> memory(3 * layout.size());
  FrameSlot slot;
  const std::span all(memory);
  slot.normal_pa = all.subspan(0, layout.size());
  slot.shear_x_pa = all.subspan(layout.size(), layout.size());
  slot.shear_y_pa = all.subspan(2 * layout.size());
  std::int64_t length_ns = 0;
  for (const auto& each : grasp.sensor.cycle) length_ns += each.duration_ns;
  TaxelRun result;
  for (std::int64_t t = 1'000'000; t < length_ns; t += 1'000'000) {
    sensor.advance(1ms);
    if (!sensor.sample(slot)) continue;
    const Estimate estimate = chain.estimate(slot.view());
    const double now_s = static_cast<double>(t) * 1e-9, truth = sensor.truth().gamma;
    ++result.frames;
    if (estimate.gamma) ++result.answered;
    if (!result.warn_due_s && truth < setup.alerts.warn_below) result.warn_due_s = now_s;
    if (!result.slip_s && truth <= 1e-9) result.slip_s = now_s;
    if (!result.alert_s && is_raised(estimate.alert)) {
      result.alert_s = now_s;
      result.alert_margin = truth;
    }
    if (result.slip_s && result.alert_s) break;
  }
  return result;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return kUnknown;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// Whether every slip had an alert, and holds had none.
bool tell(std::size_t side, std::size_t grasps, MethodChoice method, std::uint64_t seed) {
  const auto layout = TaxelLayout::grid(side, side, kPadSide_m / static_cast<double>(side));
  ChainSetup setup{.layout = layout, .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  setup.scene.objects = paper_objects();
  setup.estimator.method = method;
  Draw draw(seed);
  std::size_t in_time = 0, early = 0, alarms = 0, busy_alarms = 0, frames = 0, answered = 0;
  std::vector<double> leads, margins;
  for (std::size_t i = 0; i < grasps; ++i) {
    const TaxelRun result = run(layout, draw.slipping(), setup);
    if (result.alert_s && result.slip_s && *result.alert_s < *result.slip_s) {
      ++in_time;
      leads.push_back((*result.slip_s - *result.alert_s) / (*result.slip_s - *result.warn_due_s));
      margins.push_back(*result.alert_margin);
      if (margins.back() >= 0.5) ++early;
    } else {
      leads.push_back(0);
    }
  }
  for (const bool busy : {false, true}) {
    for (std::size_t i = 0; i < grasps; ++i) {
      const TaxelRun result = run(layout, draw.holding(busy), setup);
      if (result.alert_s) ++(busy ? busy_alarms : alarms);
      frames += result.frames;
      answered += result.answered;
    }
  }
  const auto percent = [&](std::size_t count, std::size_t of) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(of);
  };
  std::printf(
      "%3zux%-3zu  %6zu  %-8s  %8.1f %%  %8.2f  %8.2f  %8.2f  %8.1f %%  %8.1f %%  %8.1f %%  %8.1f %%\n", side,
      side, grasps, std::string(to_string(EstimatorChain(setup, nullptr).method())).c_str(),
      percent(in_time, grasps), quantile(leads, 0.5), quantile(leads, 0.05), quantile(margins, 0.5),
      percent(early, grasps), percent(alarms, grasps), percent(busy_alarms, grasps),
      percent(answered, frames));
  std::fflush(stdout);
  return in_time == grasps && 100 * (alarms + busy_alarms) <= 2 * grasps;
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int i, unsigned long otherwise) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : otherwise;
  };
  const std::size_t grasps = number(1, 1000), side = number(2, 0);
  const MethodChoice method =
      argc > 3 && std::string(argv[3]) == "fit" ? MethodChoice::fit : MethodChoice::moments;
  std::printf(
      "                            slips:                                                 holds:\n"
      "layout   grasps  method    in time     lead p50  lead p5   margin p50  at >= 0.5   plain       "
      "regripped   answered\n");
  bool good = true;
  for (const std::size_t each : side != 0 ? std::vector{side} : std::vector<std::size_t>{16, 100})
    good = tell(each, grasps, method, number(4, 1)) && good;
  return good ? 0 : 1;
}
