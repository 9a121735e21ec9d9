// `sliplab tradeoff`: error against run time, for each method on each layout and kind of noise.
#include "core/estimate/tradeoff.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/estimate/fit.hpp"
#include "core/estimate/model_setup.hpp"
#include "core/estimate/moments.hpp"
#include "core/estimate/svd_knn.hpp"
#include "core/model/train.hpp"
#include "tools/sliplab/command.hpp"
#include "tools/sliplab/gnuplot.hpp"

namespace sliplab {
namespace {

using namespace slipd;

constexpr double kHalfWidthMetres = 0.008;
constexpr Range kFriction{0.1, 0.9};  // the paper's objects

struct Case {
  std::size_t side;
  NoiseKind kind;
  double noise;
};

constexpr Case kCases[] = {
    {100, NoiseKind::relative, 0.01}, {100, NoiseKind::relative, 0.05}, {100, NoiseKind::relative, 0.10},
    {100, NoiseKind::sensor, 0.01},   {32, NoiseKind::relative, 0.01},  {32, NoiseKind::sensor, 0.01},
    {16, NoiseKind::relative, 0.01},  {16, NoiseKind::sensor, 0.01},    {8, NoiseKind::relative, 0.01},
    {8, NoiseKind::sensor, 0.01},     {4, NoiseKind::sensor, 0.01}};

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

const char* name_of(NoiseKind kind) {
  return kind == NoiseKind::relative ? "relative" : "sensor";
}

struct Line {
  Case on;
  std::string setting;
  TradeoffRow row;
};

std::vector<Line> measure(std::size_t contacts, bool models, std::uint64_t seed) {
  std::vector<Line> lines;
  for (const auto& on : kCases) {
    // The 4 x 4 fingertips that are sold have 4.7 mm of pitch.
    const double pitch = on.side == 4 ? 0.0047 : 2 * kHalfWidthMetres / static_cast<double>(on.side);
    const auto layout = TaxelLayout::grid(on.side, on.side, pitch);
    Scene scene;
    scene.objects = paper_objects();
    scene.offset_m = 0.002;
    scene.noise = on.noise;
    const auto add = [&](SlipMethod& method, const std::string& setting) {
      lines.push_back(
          {on, setting, measure_tradeoff(layout, scene, method, on.kind, on.noise, contacts, seed + 1)});
      const auto& row = lines.back().row;
      std::fprintf(stderr, "%3zux%-3zu %-8s %4.0f %%  %-10s %s\n", on.side, on.side, name_of(on.kind),
                   100 * on.noise, std::string(to_string(row.method)).c_str(), setting.c_str());
    };
    Moments moments(layout);
    add(moments, "");
    Fit fit(layout, kFriction);
    add(fit, "");
    if (!models || on.kind != NoiseKind::relative || on.side > 32) continue;
    for (const auto& [view, rank] :
         {std::pair(View::grid, 3), std::pair(View::grid, 8), std::pair(View::rings, 3)}) {
      ModelSetup setup{.layout = layout,
                       .scene = scene,
                       .size = view == View::rings ? DataSetSize{} : kUnseenFirst,
                       .seed = seed,
                       .rank = rank,
                       .neighbours = 5,
                       .view = view};
      SvdKnn knn(std::make_shared<const Model>(train(setup, std::thread::hardware_concurrency())));
      add(knn, "rank " + std::to_string(rank));
    }
  }
  return lines;
}

void print_table(const std::vector<Line>& lines, std::size_t contacts) {
  std::cout << "Error against run time: " << contacts
            << " contacts never trained on, up to 2 mm off the middle of a +-8 mm pad "
            << "(4 x 4: +-9.4 mm), Gamma uniform,\nloads rising, each frame for itself, exact taxel "
               "averages. Times: per "
            << "frame, patch included, processor time on\n"
            << processor() << ".\n\n"
            << "layout    noise          method     setting   mean err  95 %    right  answered  1 sigma  2 "
               "sigma  p50 us   p99 us\n";
  for (const auto& [on, setting, row] : lines) {
    std::printf(
        "%3zux%-3zu   %-8s %3.0f %%  %-10s %-8s  %.4f    %.4f  %5.1f %%  %5.1f %%  %5.1f %%  %5.1f %%  %7.1f "
        " %7.1f\n",
        on.side, on.side, name_of(on.kind), 100 * on.noise, std::string(to_string(row.method)).c_str(),
        setting.c_str(), row.mean_error, row.p95_error, 100 * row.right, 100 * row.answered,
        100 * row.within_sigma, 100 * row.within_two_sigma, row.p50_us, row.p99_us);
  }
}

nlohmann::ordered_json as_json(const std::vector<Line>& lines, std::size_t contacts) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& [on, setting, row] : lines) {
    rows.push_back({{"columns", on.side},
                    {"noise_kind", name_of(on.kind)},
                    {"noise", on.noise},
                    {"method", to_string(row.method)},
                    {"setting", setting},
                    {"mean_error", row.mean_error},
                    {"p95_error", row.p95_error},
                    {"class_right", row.right},
                    {"answered", row.answered},
                    {"within_sigma", row.within_sigma},
                    {"within_two_sigma", row.within_two_sigma},
                    {"p50_us", row.p50_us},
                    {"p99_us", row.p99_us}});
  }
  return {{"contacts", contacts}, {"processor", processor()}, {"rows", std::move(rows)}};
}

void write_files(const std::vector<Line>& lines, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ostringstream csv;
  csv << "columns,noise_kind,noise,method,setting,mean_error,p95_error,class_right,answered,within_sigma,"
         "within_two_sigma,"
         "p50_us,p99_us\n";
  for (const auto& [on, setting, row] : lines) {
    csv << on.side << ',' << name_of(on.kind) << ',' << on.noise << ',' << to_string(row.method) << ','
        << setting << ',' << row.mean_error << ',' << row.p95_error << ',' << row.right << ',' << row.answered
        << ',' << row.within_sigma << ',' << row.within_two_sigma << ',' << row.p50_us << ',' << row.p99_us
        << '\n';
  }
  write_file(folder / "tradeoff.csv", csv.str());
  plot(folder, "tradeoff",
       "set terminal svg size 900,560 font 'sans,13' background 'white'\nset output 'tradeoff.svg'\n"
       "set datafile separator ','\nset logscale xy\nset xlabel 'time per frame, us'\nset ylabel 'mean "
       "|error| of Gamma'\n"
       "set grid\nset key outside right\nset title 'Work and precision: a point a layout and noise, left and "
       "low is better'\n"
       "plot for [m in 'moments fit registered svd-knn'] 'tradeoff.csv' using (strcol(4) eq m ? $12 : NaN):6 "
       "with "
       "points pt 7 ps 0.8 "
       "title m, '' using (strcol(4) eq 'fit' ? $12 : NaN):6:(sprintf('%s²', strcol(1))) with labels offset "
       "1,0.7 notitle\n");
}

void run(const Common& common, std::size_t contacts, bool models) {
  const auto lines = measure(contacts, models, common.seed);
  if (common.json) {
    std::cout << as_json(lines, contacts).dump(2) << '\n';
  } else {
    print_table(lines, contacts);
  }
  if (!common.out.empty()) write_files(lines, common.out);
}

}  // namespace

void add_tradeoff(CLI::App& app, const Common& common) {
  auto* command = app.add_subcommand("tradeoff", "error against run time, for each method, layout and noise");
  auto contacts = std::make_shared<std::size_t>(1000);
  auto models = std::make_shared<bool>(true);
  command->add_option("--contacts", *contacts, "of each row")
      ->check(CLI::Range(10, 1000000))
      ->capture_default_str();
  command->add_flag("!--no-models", *models, "leave out what has to be trained first");
  command->callback([&common, contacts, models] { run(common, *contacts, *models); });
}

}  // namespace sliplab
