// estimators-bench: what a frame costs: each method on each layout, what grows with taxels and with a model's
// points, the whole chain, and the floors that no method can pass. Times are of one frame each, one thread.
// With SLIPD_BENCH_PEER=1 the frames, basis and points go to files as well, for peers to work on the same.
#include <benchmark/benchmark.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>

#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "paper/dataset/alpha.hpp"
#include "paper/method/svd_knn.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tests/bench/scenes.hpp"
#include "tests/bench/times.hpp"

namespace slipd::bench {
namespace {

constexpr std::size_t kFrames = 64;  // of 100 x 100: 7.7 MB, beyond a core's own cache, within the shared one

std::unique_ptr<SlipMethod> make(const ChainSetup& setup) {
  switch (setup.estimator.method) {
    case MethodChoice::moments:
      return std::make_unique<Moments>(setup.layout);
    case MethodChoice::fit:
      return make_fit(setup.layout, expected_friction(setup.scene));
    default:
      return std::make_unique<SvdKnn>(model_of(setup));
  }
}

void time_method(benchmark::State& state, const ChainSetup& setup, SlipMethod& method) {
  Frames frames(setup, kFrames);
  PatchFinder finder(setup.layout);
  Times times;
  std::size_t answered = 0, asked = 0;
  for (auto _ : state) {
    const Frame& frame = frames.next();
    const std::int64_t since = now_ns();
    const ContactPatch& patch = finder.find(frame);
    const Reading reading = method.estimate(frame, patch);
    times.add(since);
    answered += reading.in_model ? 1 : 0;
    ++asked;
  }
  times.report(state);
  state.counters["answered"] = static_cast<double>(answered) / static_cast<double>(asked);
}

void method_of_side(benchmark::State& state, MethodChoice choice) {
  const auto setup = setup_of(static_cast<std::size_t>(state.range(0)), choice);
  const auto method = make(setup);
  time_method(state, setup, *method);
}

// svd-knn on 16 x 16 by a model of more and more points.
void method_of_points(benchmark::State& state) {
  const auto setup = setup_of(16, MethodChoice::svd_knn);
  SvdKnn method(model_of(setup, static_cast<std::size_t>(state.range(0)) / 10));
  time_method(state, setup, method);
}

void chain_of_side(benchmark::State& state, MethodChoice choice) {
  const auto side = static_cast<std::size_t>(state.range(0));
  const auto setup = setup_of(side, choice);
  EstimatorChain chain(setup, needs_model(setup) ? model_of(setup) : nullptr);
  Grasp grasp(side, 200);
  Times times;
  std::size_t answered = 0, asked = 0;
  for (auto _ : state) {
    const Frame& frame = grasp.next();
    const std::int64_t since = now_ns();
    const Estimate estimate = chain.estimate(frame);
    times.add(since);
    answered += estimate.state == State::ok ? 1 : 0;
    ++asked;
  }
  times.report(state);
  state.counters["answered"] = static_cast<double>(answered) / static_cast<double>(asked);
  if (asked >= 1000 && 2 * answered < asked)
    state.SkipWithError("the chain answers less than half of the frames");
}

// A frame from the shared cache, read once by memcpy.
void floor_frame(benchmark::State& state) {
  const auto setup = setup_of(static_cast<std::size_t>(state.range(0)), MethodChoice::moments);
  Frames frames(setup, kFrames);
  std::vector<float> to(3 * setup.layout.size());
  Times times;
  for (auto _ : state) {
    const float* from = frames.next().normal_pa.data();
    const std::int64_t since = now_ns();
    std::memcpy(to.data(), from, sizeof(float) * to.size());
    benchmark::ClobberMemory();
    times.add(since);
  }
  times.report(state);
}

// One least-squares step: six unknowns, two residuals of each taxel of the frame.
void floor_step(benchmark::State& state) {
  constexpr int kUnknowns = 6;
  const Eigen::Index rows = 2 * state.range(0) * state.range(0);
  const Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> slopes =
      Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>::Random(rows, kUnknowns);
  const Eigen::VectorXd residuals = Eigen::VectorXd::Random(rows);
  Times times;
  for (auto _ : state) {
    const std::int64_t since = now_ns();
    const Eigen::Matrix<double, kUnknowns, kUnknowns> hessian = slopes.transpose() * slopes;
    Eigen::Matrix<double, kUnknowns, 1> step = hessian.ldlt().solve(slopes.transpose() * residuals);
    benchmark::DoNotOptimize(step.data());
    benchmark::ClobberMemory();
    times.add(since);
  }
  times.report(state);
}

// A frame from the shared cache and the basis from the core's own, each read once by memcpy.
void floor_memcpy(benchmark::State& state) {
  const auto setup = setup_of(100, MethodChoice::moments);
  Frames frames(setup, kFrames);
  const std::vector<float> basis(8 * setup.layout.size(), 1.0F);
  std::vector<float> to(3 * setup.layout.size()), basis_to(basis.size());
  Times times;
  for (auto _ : state) {
    const float* from = frames.next().normal_pa.data();
    const std::int64_t since = now_ns();
    std::memcpy(to.data(), from, sizeof(float) * to.size());
    std::memcpy(basis_to.data(), basis.data(), sizeof(float) * basis.size());
    benchmark::ClobberMemory();
    times.add(since);
  }
  times.report(state);
}

void floor_gemv(benchmark::State& state) {
  const Eigen::MatrixXf basis = Eigen::MatrixXf::Random(8, 10000);
  Eigen::VectorXf alpha = Eigen::VectorXf::Random(10000), point(8);
  Times times;
  for (auto _ : state) {
    const std::int64_t since = now_ns();
    point.noalias() = basis * alpha;
    benchmark::DoNotOptimize(point.data());
    benchmark::ClobberMemory();
    times.add(since);
  }
  times.report(state);
}

// The exact search alone, on the points of contacts that the model has not seen.
void floor_search(benchmark::State& state) {
  const auto setup = setup_of(100, MethodChoice::svd_knn);
  const auto model = model_of(setup);
  const Frames frames(setup, kFrames);
  const std::size_t rank = model->rank(), taxels = setup.layout.size();
  std::vector<float> alpha(taxels), points;
  for (const Frame& frame : frames.all()) {
    const float peak = *std::max_element(frame.normal_pa.begin(), frame.normal_pa.end());
    PatchFinder finder(setup.layout);
    const ContactPatch& patch = finder.find(frame);
    alpha_of(frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa,
             {.least_pa = peak * mask_fraction(kNoise),
              .along_x = static_cast<float>(patch.direction_x),
              .along_y = static_cast<float>(patch.direction_y)},
             alpha);
    for (std::size_t k = 0; k < rank; ++k) {
      float sum = 0;
      for (std::size_t i = 0; i < taxels; ++i) sum += alpha[i] * model->data().basis[i * rank + k];
      points.push_back(sum);
    }
  }
  Neighbours::Query query(model->neighbours(), 5);
  Times times;
  std::size_t at = 0;
  for (auto _ : state) {
    const std::int64_t since = now_ns();
    benchmark::DoNotOptimize(query.find(std::span(points).subspan(rank * at, rank)));
    times.add(since);
    at = (at + 1) % kFrames;
  }
  times.report(state);
}

// What a peer needs to do the same: X, Y and normal of each frame, basis, points, margins.
void hand_over() {
  const auto setup = setup_of(100, MethodChoice::svd_knn);
  const auto model = model_of(setup);
  const Frames frames(setup, kFrames);
  using List = std::vector<std::span<const float>>;
  const auto write = [](const char* name, const List& lists) {
    std::ofstream out(folder() / name, std::ios::binary);
    for (const auto& list : lists)
      out.write(reinterpret_cast<const char*>(list.data()),
                static_cast<std::streamsize>(list.size() * sizeof(float)));
  };
  List all;
  for (const Frame& frame : frames.all())
    for (const auto& channel : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa}) all.push_back(channel);
  write("frames.f32", all);
  write("basis.f32", List{model->data().basis});
  write("points.f32", List{model->data().coordinates});
  write("gamma.f32", List{model->data().gamma});
}

void register_all() {
  using TaxelRun = void (*)(benchmark::State&, MethodChoice);
  const std::pair<const char*, MethodChoice> methods[] = {{"moments", MethodChoice::moments},
                                                          {"svd-knn", MethodChoice::svd_knn},
                                                          {"registered", MethodChoice::registered},
                                                          {"fit", MethodChoice::fit}};
  const auto add = [](const std::string& name, auto run, std::vector<std::int64_t> sizes) {
    auto* const made = benchmark::RegisterBenchmark(name.c_str(), run);
    for (const std::int64_t size : sizes) made->Arg(size);
    made->UseRealTime()->Unit(benchmark::kMicrosecond);
  };
  for (const auto& [name, choice] : methods) {
    const TaxelRun method = method_of_side, chain = chain_of_side;
    const auto bind = [choice = choice](TaxelRun run) {
      return [run, choice](benchmark::State& s) { run(s, choice); };
    };
    // Training on more taxels than the paper's takes minutes; the methods that need none go on.
    const bool trained = choice == MethodChoice::svd_knn || choice == MethodChoice::registered;
    add(std::string("method/") + name, bind(method),
        trained ? std::vector<std::int64_t>{4, 8, 16, 32, 64, 100}
                : std::vector<std::int64_t>{4, 8, 16, 32, 64, 100, 160, 256});
    add(std::string("chain/") + name, bind(chain), {4, 16, 100});
  }
  add("points/svd-knn", method_of_points, {1000, 10000, 100000, 1000000});
  add("floor/frame", floor_frame, {100});
  add("floor/step", floor_step, {16, 100});
  add("floor/memcpy", floor_memcpy, {});
  add("floor/gemv", floor_gemv, {});
  add("floor/search", floor_search, {});
}

}  // namespace
}  // namespace slipd::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  slipd::bench::register_all();
  if (const char* const peer = std::getenv("SLIPD_BENCH_PEER"); peer != nullptr && *peer != '\0')
    slipd::bench::hand_over();
  benchmark::RunSpecifiedBenchmarks();
}
