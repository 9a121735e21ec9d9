// `sliplab picture`: plots a recording for documents: its margin with 2 sigma, its alerts, its forces, and
// the taxels of one frame. Writes the numbers as CSV files, too.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "core/estimate/estimate.hpp"
#include "tools/offline/gnuplot.hpp"
#include "tools/recorded/recorded.hpp"
#include "tools/sliplab/command.hpp"

namespace sliplab {
namespace {

using slipd::FrameSummary;
using slipd::Recorded;

struct PictureOptions {
  std::filesystem::path file;
  std::string format = "svg";
  std::optional<double> at_s;
};

std::string course_csv(const Recorded& recorded) {
  std::ostringstream csv;
  csv << "time_s,normal_n,shear_n,true_gamma,gamma,sigma,friction,state,alert\n";
  for (const FrameSummary& frame : recorded.frames) {
    const slipd::RecordedEstimate estimate = frame.estimate.value_or(slipd::RecordedEstimate{});
    csv << frame.time_s << ',' << frame.normal_n << ',' << frame.shear_n << ',' << frame.truth_gamma << ','
        << estimate.gamma << ',' << estimate.sigma << ',' << estimate.friction << ',';
    if (frame.estimate) csv << int{estimate.state} << ',' << int{estimate.alert};
    if (!frame.estimate) csv << "nan,nan";
    csv << '\n';
  }
  return csv.str();
}

std::string taxels_csv(const Recorded& recorded) {
  const auto& layout = recorded.header.layout;
  std::ostringstream csv;
  csv << "x_mm,y_mm,normal_kpa,shear_x_kpa,shear_y_kpa\n";
  for (std::size_t i = 0; i < layout.size(); ++i) {
    csv << 1e3 * layout.x_m()[i] << ',' << 1e3 * layout.y_m()[i] << ',' << 1e-3 * recorded.normal_pa[i] << ','
        << 1e-3 * recorded.shear_x_pa[i] << ',' << 1e-3 * recorded.shear_y_pa[i] << '\n';
  }
  return csv.str();
}

// Quotes a name for gnuplot, without its marks for sub- and superscripts.
std::string quoted(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\'') safe += '\'';
    if (c != '\n') safe += c;
  }
  return "'" + safe + "'";
}

// Arrows of one pitch where shear is greatest.
double arrow_mm_per_kpa(const Recorded& recorded) {
  double greatest = 0;
  for (std::size_t i = 0; i < recorded.shear_x_pa.size(); ++i)
    greatest = std::max(greatest, std::hypot(static_cast<double>(recorded.shear_x_pa[i]),
                                             static_cast<double>(recorded.shear_y_pa[i])));
  return greatest > 0 ? 1e3 * recorded.header.layout.side_m() / (1e-3 * greatest) : 0;
}

std::string script_of(const Recorded& recorded, const std::string& name, const PictureOptions& options) {
  const bool map = recorded.header.layout.size() > 1;
  const FrameSummary& shown = recorded.frames[recorded.shown];
  std::ostringstream script;
  script << (options.format == "png" ? "set terminal pngcairo size 900," : "set terminal svg size 900,")
         << (map ? 900 : 560) << " noenhanced font 'sans,12' background 'white'\n"
         << "set output " << quoted(name + "." + options.format) << "\nset datafile separator ','\n"
         << "set multiplot title "
         << quoted(recorded.header.sensor + (recorded.header.simulated ? " (simulated)" : "") + ": " +
                   recorded.header.description)
         << "\nset grid\nset key outside right top\nset lmargin 10\nset rmargin 22\nset xrange [0:"
         << std::max(recorded.seconds(), 1e-3) << "]\nset size 1," << (map ? 0.33 : 0.5) << "\nset origin 0,"
         << (map ? 0.63 : 0.46) << "\nset ylabel 'safety margin'\nset yrange [-0.05:1.05]\n"
         << "set style fill transparent solid 0.25 noborder\n"
         << "plot " << quoted(name + ".csv")
         << " skip 1 using 1:($9==2?1:NaN) with impulses lc rgb '#f4c7c3' title "
         << "'slip alert', '' skip 1 using 1:($5-2*$6):($5+2*$6) with filledcurves lc rgb '#4a90d9' title '2 "
            "sigma', "
         << "'' skip 1 using 1:5 with lines lc rgb '#1f4e8c' lw 1.5 title 'estimated', "
         << "'' skip 1 using 1:4 with lines lc rgb 'black' dt 2 title 'true', "
         << "'-' using 1:2 with points pt 11 lc rgb 'black' notitle\n"
         << shown.time_s << ",0\ne\nset origin 0," << (map ? 0.34 : 0.0) << "\nset size 1,"
         << (map ? 0.30 : 0.46) << "\nset yrange [0:*]\nset ylabel 'force, N'\nset xlabel 'time, s'\n"
         << "plot " << quoted(name + ".csv")
         << " skip 1 using 1:2 with lines lc rgb '#2a7f9e' title 'normal', "
         << "'' skip 1 using 1:3 with lines lc rgb '#8e44ad' title 'shear'\n";
  if (map) {
    script << "set origin 0.25,0\nset size 0.5,0.35\nset lmargin 6\nset rmargin 8\nunset key\nset size ratio "
              "-1\n"
           << "set title 'at " << shown.time_s
           << " s'\nset xlabel 'mm'\nset ylabel 'mm'\nset cblabel 'pressure, kPa'\n"
           << "set autoscale x\nset autoscale y\nset cbrange [0:*]\n"
           << "set palette defined (0 '#16122c', 1 '#561c6e', 2 '#bc3754', 3 '#f58c28', 4 '#fcfaaa')\n"
           << "plot " << quoted(name + "-taxels.csv") << " skip 1 using 1:2:3 with points pt 5 ps "
           << std::clamp(30 / std::sqrt(static_cast<double>(recorded.header.layout.size())), 0.4, 3.0)
           << " lc palette, '' skip 1 using 1:2:($4*" << arrow_mm_per_kpa(recorded) << "):($5*"
           << arrow_mm_per_kpa(recorded) << ") with vectors lc rgb '#30c0a0'\n";
  }
  script << "unset multiplot\n";
  return script.str();
}

void run(const offline::Common& common, const PictureOptions& options) {
  const std::filesystem::path folder = common.out.empty() ? "." : common.out;
  const Recorded recorded = slipd::read_recorded(options.file, options.at_s);
  if (!recorded.fault.empty()) std::cerr << "sliplab: " << recorded.fault << "; the rest is drawn\n";
  std::filesystem::create_directories(folder);
  const std::string name = options.file.stem().string();
  offline::write_file(folder / (name + ".csv"), course_csv(recorded));
  offline::write_file(folder / (name + "-taxels.csv"), taxels_csv(recorded));
  offline::plot(folder, name, script_of(recorded, name, options));
  const auto picture = folder / (name + "." + options.format);
  if (common.json) {
    std::cout << nlohmann::ordered_json{{"picture", picture.string()},
                                        {"frames", recorded.frames.size()},
                                        {"seconds", recorded.seconds()},
                                        {"estimates", recorded.has_estimates()}}
                     .dump()
              << '\n';
  } else {
    std::cout << recorded.frames.size() << " frames of " << recorded.header.sensor << " are drawn in "
              << picture.string() << '\n';
  }
}

}  // namespace

void add_picture(CLI::App& app, const offline::Common& common) {
  auto* command =
      app.add_subcommand("picture", "draw a recording by gnuplot, into --out or the current folder");
  auto options = std::make_shared<PictureOptions>();
  command->add_option("file", options->file, "a recording of slipd")->required()->check(CLI::ExistingFile);
  command->add_option("--format", options->format, "format of the file: svg or png")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
  command->add_option(
      "--at", options->at_s,
      "time of the frame whose taxels are drawn, s from the beginning; default: the frame with the "
      "least margin, without estimates that of greatest normal force");
  command->callback([&common, options] { run(common, *options); });
}

}  // namespace sliplab
