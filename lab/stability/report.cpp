#include "lab/stability/report.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "lab/options.hpp"
#include "lab/report.hpp"
#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

using slipd::State;

void print_model(const std::vector<ContactModelError>& rows) {
  std::puts(
      "The contact model against 60 digits: largest relative error of a, p0, c, Q, p, q, alpha over drawn "
      "contacts.\nhistory: q as a sum of disc terms, of the contact's largest q. alpha: in single precision, "
      "as estimators take it.\ninf: the textbook's form divides by nothing.\n\n"
      "  along            at   slipd    history  alpha (single)   textbook (double)  textbook (single)");
  for (const auto& row : rows) {
    std::printf("  %-8s %10.6g   %.0e    %.0e    %.0e            %.0e              %.0e\n",
                std::string(name_of(row.axis)).c_str(), row.place, row.closed_form, row.history,
                row.single_angle, row.textbook_double, row.textbook_single);
  }
}

// "-" where nothing was answered.
std::string number(double value, const char* form) {
  if (std::isnan(value)) return "-";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), form, value);
  return text.data();
}

void print_robustness(const char* title, const std::vector<RobustnessRow>& rows) {
  std::printf("\n%s\n\n  %-24s", title, "");
  for (const auto& method : kUntrained) std::printf("  %-52s", method.name);
  std::printf("\n  %-10s %13s", "along", "at");
  for (std::size_t m = 0; m < std::size(kUntrained); ++m)
    std::printf("  %8s %8s %8s %8s %8s %7s", "answered", "error", "safer", "less", "2 sigma", "outside");
  std::puts("");
  for (const auto& row : rows) {
    std::printf("  %-10s %13.6g", row.what.c_str(), row.strength);
    for (const auto& t : row.by_method) {
      std::printf("  %7.1f%% %8s %8s %8s %8s %6.1f%%", 100 * t.answered(),
                  number(t.mean_error(), "%.4f").c_str(), number(100 * t.overestimated(), "%.1f%%").c_str(),
                  number(100 * t.underestimated(), "%.1f%%").c_str(),
                  number(100 * t.within(2), "%.1f%%").c_str(), 100 * t.in_state(State::out_of_model));
    }
    std::puts("");
  }
}

void print_condition(const Stability& found) {
  std::printf(
      "\nCondition: standard deviation of Gamma over the standard deviation of one taxel (of the "
      "largest p). limit: the\nleast possible (Cramer-Rao). -: no answer.\n\n  Gamma ");
  for (const auto& name : found.methods) std::printf("  %10s", name.c_str());
  std::printf("  %10s\n", "limit");
  for (const auto& row : found.condition) {
    std::printf("  %.2f  ", row.gamma);
    for (const double value : row.by_method) std::printf("  %10s", number(value, "%.3g").c_str());
    std::printf("  %10.3g\n", row.limit);
  }
  std::printf(
      "\nMean change of Gamma when readings keep so many significant bits instead of a float's 24.\n\n"
      "  bits  ");
  for (const auto& name : found.methods) std::printf("  %10s", name.c_str());
  std::puts("");
  for (const auto& row : found.bits) {
    std::printf("  %4d  ", row.bits);
    for (const double value : row.by_method) std::printf("  %10s", number(value, "%.1e").c_str());
    std::puts("");
  }
}

std::size_t not_finite(const std::vector<RobustnessRow>& rows) {
  std::size_t count = 0;
  for (const auto& row : rows) count += row.not_finite;
  return count;
}

nlohmann::ordered_json row_of(const RobustnessRow& row, std::size_t method,
                              std::initializer_list<const char*> keys) {
  nlohmann::ordered_json out{{"along", row.what}, {"at", row.strength}, {"method", kUntrained[method].name}};
  out.update(to_json(row.by_method[method], keys));
  return out;
}

nlohmann::ordered_json json_of(const std::vector<RobustnessRow>& rows) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const auto& row : rows) {
    for (std::size_t m = 0; m < row.by_method.size(); ++m)
      out.push_back(row_of(row, m,
                           {"answered", "mean_error", "claims_safer", "claims_less_safe", "within_two_sigma",
                            "out_of_model"}));
  }
  return out;
}

// Rows of one method follow each other, as a plot's lines want it.
void write_robustness(const std::vector<RobustnessRow>& rows, const std::filesystem::path& file) {
  std::vector<nlohmann::ordered_json> all;
  for (std::size_t m = 0; m < std::size(kUntrained); ++m) {
    for (const auto& row : rows)
      all.push_back(
          row_of(row, m,
                 {"frames", "answered", "mean_error", "worst_error", "claims_safer", "claims_less_safe",
                  "within_sigma", "within_two_sigma", "no_contact", "learning", "out_of_model"}));
  }
  offline::write_file(file, to_csv(all, {"along", "at", "method", "frames", "answered", "mean_error",
                                         "worst_error", "claims_safer", "claims_less_safe", "within_sigma",
                                         "within_two_sigma", "no_contact", "learning", "out_of_model"}));
}

void plot_model(const Stability& found, const std::filesystem::path& folder) {
  std::ostringstream csv;
  csv << "along,at,slipd,history,alpha_single,textbook_double,textbook_single\n";
  for (const auto& row : found.model) {
    csv << name_of(row.axis) << ',' << row.place << ',' << row.closed_form << ',' << row.history << ','
        << row.single_angle << ',' << row.textbook_double << ',' << row.textbook_single << '\n';
  }
  offline::write_file(folder / "extremes-model.csv", csv.str());
  offline::plot(
      folder, "extremes-model",
      "set terminal svg size 900,420 font 'sans,12' background 'white'\nset output 'extremes-model.svg'\n"
      "set datafile separator ','\nset logscale xy\nset format '10^{%L}'\nset grid\nset yrange [1e-17:10]\n"
      "set ylabel 'largest relative error'\nset key off\nset multiplot layout 1,2\n"
      "set xlabel '1 - Gamma'\nset title 'Light load'\n"
      "plot for [c in '3 6'] 'extremes-model.csv' using (strcol(1) eq '1-Gamma' ? $2 : NaN):(column(int(c))) "
      "with linespoints pt 7 ps 0.5 lc rgb (c eq '3' ? '#1f4e8c' : '#c0392b')\n"
      "set key left top\nset xlabel 'E2/E1'\nset title 'Stiff objects'\n"
      "plot 'extremes-model.csv' using (strcol(1) eq 'E2/E1' ? $2 : NaN):3 with linespoints pt 7 ps 0.5 lc "
      "rgb '#1f4e8c' title 'slipd', '' using (strcol(1) eq 'E2/E1' ? $2 : NaN):6 with linespoints pt 7 ps "
      "0.5 lc rgb '#c0392b' title 'textbook, double', '' using (strcol(1) eq 'E2/E1' ? $2 : NaN):5 with "
      "linespoints pt 7 ps 0.5 lc rgb '#7f8c8d' title 'alpha, single'\nunset multiplot\n");
}

void plot_condition(const Stability& found, const std::filesystem::path& folder) {
  std::ostringstream csv, bits;
  csv << "gamma";
  bits << "bits";
  for (const auto& name : found.methods) {
    csv << ',' << name;
    bits << ',' << name;
  }
  csv << ",limit\n";
  bits << '\n';
  for (const auto& row : found.condition) {
    csv << row.gamma;
    for (const double value : row.by_method) csv << ',' << value;
    csv << ',' << row.limit << '\n';
  }
  for (const auto& row : found.bits) {
    bits << row.bits;
    for (const double value : row.by_method) bits << ',' << value;
    bits << '\n';
  }
  offline::write_file(folder / "condition.csv", csv.str());
  offline::write_file(folder / "bits.csv", bits.str());
  std::ostringstream script;
  script << "set terminal svg size 900,420 font 'sans,12' background 'white'\nset output 'condition.svg'\n"
            "set datafile separator ','\nset logscale y\nset grid\nset key left top horizontal samplen "
            "2\nset yrange "
            "[0.1:1000]\n"
            "set multiplot layout 1,2\nset xlabel 'Gamma'\nset ylabel 'margin error / frame error'\n"
            "set title '"
         << found.setup.side << " x " << found.setup.side << ", " << name_of(found.setup.kind)
         << " noise'\nplot for [c=2:" << found.methods.size() + 1
         << "] 'condition.csv' using 1:c with linespoints pt 7 ps 0.5 title columnheader(c), '' using 1:"
         << found.methods.size() + 2
         << " with lines lc rgb 'black' dt 2 title 'theoretical bound'\n"
            "set xlabel 'significant bits of a reading'\nset ylabel 'mean change of Gamma'\n"
            "set title 'Bits that matter'\nset autoscale y\nset key right top vertical\nplot for [c=2:"
         << found.methods.size() + 1
         << "] 'bits.csv' using 1:c with linespoints pt 7 ps 0.5 title columnheader(c)\nunset multiplot\n";
  offline::plot(folder, "condition", script.str());
}

void plot_perturbations(const std::filesystem::path& folder) {
  std::ostringstream script;
  script << "set terminal svg size 900,1250 font 'sans,11' background 'white'\nset output 'adversary.svg'\n"
            "set datafile separator ','\nset grid\nset multiplot layout 5,2\nset yrange [0:0.4]\n"
            "set ytics nomirror\nset y2range [0:100]\nset y2tics 50\nset ylabel 'error of the margin'\n"
            "set y2label 'share, %'\nset key right top\n";
  for (std::size_t f = 0; f < kPerturbations; ++f) {
    const auto perturbation = static_cast<Perturbation>(f);
    const std::string pick =
        "(strcol(1) eq '" + std::string(name_of(perturbation)) + "' && strcol(3) eq 'fit'";
    const std::string cheap =
        "(strcol(1) eq '" + std::string(name_of(perturbation)) + "' && strcol(3) eq 'moments'";
    script << "set title '" << name_of(perturbation) << "'\nset xlabel '" << strength_of(perturbation)
           << "'\nplot 'adversary.csv' using " << pick
           << " ? $2 : NaN):6 with linespoints pt 7 ps 0.5 lc rgb '#1f4e8c' title 'error of fit (left)', '' "
              "using "
           << pick
           << " ? $2 : NaN):(100*$8*$5) axes x1y2 with linespoints pt 7 ps 0.5 lc rgb '#c0392b' title "
              "'overestimates, % (right)', '' using "
           << pick
           << " ? $2 : NaN):(100*(1-$5)) axes x1y2 with lines dt 2 lc rgb '#7f8c8d' title 'without a margin, "
              "% (right)', '' using "
           << cheap << " ? $2 : NaN):6 with lines lc rgb '#e67e22' title 'error of moments (left)'\n"
           << (f == 0 ? "set key off\n" : "");
  }
  script << "unset multiplot\n";
  offline::plot(folder, "adversary", script.str());
}

}  // namespace

void print_table(const Stability& found) {
  if (!found.model.empty()) print_model(found.model);
  if (!found.extremes.empty() || !found.perturbations.empty() || !found.condition.empty() ||
      !found.turning.empty()) {
    std::printf(
        "\nContacts of the paper's, up to 2 mm off the middle of a +-8 mm pad, %zu x %zu taxels, "
        "noise %g %% (%s), %zu a row,\neach frame for itself. safer, less: answers off by more than "
        "%g, of those answered. outside: state out_of_model.\n",
        found.setup.side, found.setup.side, 100 * found.setup.noise, name_of(found.setup.kind),
        found.setup.contacts, kGrossError);
  }
  if (!found.extremes.empty()) print_robustness("Estimates at extreme parameters.", found.extremes);
  if (!found.condition.empty()) print_condition(found);
  if (!found.perturbations.empty())
    print_robustness("Estimates of contacts that deviate from the model.", found.perturbations);
  if (!found.turning.empty()) {
    print_robustness(
        "Estimates under force and torque. mixture: degrees from a pull, 0, to a torque alone, 90; load: "
        "share "
        "of what friction holds.\nOne row, one taxel: over time, friction given, at a mixture.",
        found.turning);
    std::printf("\nEstimates with a number that is not finite: %zu\n", not_finite(found.turning));
  }
}

offline::SweepResult to_sweep(const Stability& found, const offline::Shard& shard) {
  nlohmann::ordered_json model = nlohmann::ordered_json::array();
  for (const auto& row : found.model) {
    model.push_back({{"along", name_of(row.axis)},
                     {"at", row.place},
                     {"slipd", row.closed_form},
                     {"history", row.history},
                     {"alpha_single", row.single_angle},
                     {"textbook_double", row.textbook_double}});
  }
  nlohmann::ordered_json condition = nlohmann::ordered_json::array();
  for (const auto& row : found.condition) {
    nlohmann::ordered_json line{{"gamma", row.gamma}, {"limit", row.limit}};
    for (std::size_t m = 0; m < row.by_method.size(); ++m) line[found.methods[m]] = row.by_method[m];
    condition.push_back(std::move(line));
  }
  nlohmann::ordered_json bits = nlohmann::ordered_json::array();
  for (const auto& row : found.bits) {
    nlohmann::ordered_json line{{"bits", row.bits}};
    for (std::size_t m = 0; m < row.by_method.size(); ++m) line[found.methods[m]] = row.by_method[m];
    bits.push_back(std::move(line));
  }
  const nlohmann::ordered_json none = nlohmann::ordered_json::array();
  offline::SweepResult sweep{{{"columns", found.setup.side},
                              {"noise_kind", name_of(found.setup.kind)},
                              {"noise", found.setup.noise},
                              {"contacts", found.setup.contacts},
                              {"model", none},
                              {"extremes", none},
                              {"condition", none},
                              {"bits", none},
                              {"adversary", none},
                              {"turning", none},
                              {"not_finite", 0}},
                             {}};
  const auto add = [&](StabilityPart part, nlohmann::ordered_json value) {
    if (shard.has(part)) sweep.units.push_back({part, std::move(value)});
  };
  add(model_part, {{"model", std::move(model)}});
  add(extremes_part, {{"extremes", json_of(found.extremes)}});
  add(condition_part, {{"condition", std::move(condition)}, {"bits", std::move(bits)}});
  add(adversary_part, {{"adversary", json_of(found.perturbations)}});
  add(torque_part, {{"turning", json_of(found.turning)}, {"not_finite", not_finite(found.turning)}});
  return sweep;
}

void write_files(const Stability& found, const std::filesystem::path& folder) {
  if (!found.model.empty()) plot_model(found, folder);
  if (!found.extremes.empty()) write_robustness(found.extremes, folder / "extremes.csv");
  if (!found.turning.empty()) write_robustness(found.turning, folder / "extremes-torque.csv");
  if (!found.condition.empty()) plot_condition(found, folder);
  if (!found.perturbations.empty()) {
    write_robustness(found.perturbations, folder / "adversary.csv");
    plot_perturbations(folder);
  }
}

}  // namespace lab
