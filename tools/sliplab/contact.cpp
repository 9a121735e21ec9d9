// `sliplab contact FILE.csv`: evaluates the contact model for a table of cases, for users and for comparison
// with other tools.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/contact/cattaneo_mindlin.hpp"
#include "tools/sliplab/command.hpp"

namespace sliplab {
namespace {

using namespace slipd::contact;

constexpr std::array kInputs{"P_N",  "mu",    "R1_m", "E1_Pa",           "nu1",
                             "R2_m", "E2_Pa", "nu2",  "one_minus_gamma", "s"};
constexpr std::array kResults{"Estar_Pa", "R_m", "a_m", "p0_Pa", "c_m", "Q_N", "p_Pa", "q_Pa", "alpha_rad"};
using Inputs = std::array<double, kInputs.size()>;
using Results = std::array<double, kResults.size()>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (!cells.empty() && cells.back().ends_with('\r')) cells.back().pop_back();
  return cells;
}

double number_in(const std::string& cell, const char* column) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  // Too small for a double is 0 or subnormal, which strtod gives; too large stays an error.
  if (error == std::errc::result_out_of_range && end == cell.data() + cell.size())
    return std::strtod(cell.c_str(), nullptr);
  if (error != std::errc{} || end != cell.data() + cell.size()) {
    throw std::runtime_error(std::string(column) + " = '" + cell + "' is no number");
  }
  return value;
}

Results compute(const Inputs& in) {
  const auto [normal, mu, r1, e1, nu1, r2, e2, nu2, load, s] = in;
  if (!(s >= 0)) throw ContactError("s: must be a position r/a of 0 or more");
  const BodyPair pair = make_body_pair({r1, e1, nu1}, {r2, e2, nu2});
  const CattaneoMindlin contact(pair, normal, mu, load);
  const Traction at = contact.at(s);
  return {pair.modulus_pa,
          pair.radius_m,
          contact.contact_radius_m(),
          contact.peak_pressure_pa(),
          contact.stick_radius_m(),
          contact.shear_n(),
          at.pressure_pa,
          at.shear_pa,
          at.angle_rad};
}

template <std::size_t N>
void print(std::ostream& out, const std::array<double, N>& values, bool first) {
  for (const double value : values) {
    std::array<char, 32> text;
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 17).ptr;
    out << (first ? "" : ",") << std::string_view(text.data(), static_cast<std::size_t>(end - text.data()));
    first = false;
  }
}

void run(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": cannot be read");
  std::string line;
  std::getline(in, line);
  const auto header = cells_of(line);
  std::array<std::size_t, kInputs.size()> place;
  for (std::size_t i = 0; i < kInputs.size(); ++i) {
    const auto found = std::find(header.begin(), header.end(), kInputs[i]);
    if (found == header.end()) {
      throw std::runtime_error(file + ":1: column " + kInputs[i] +
                               " is missing; the first line names the columns");
    }
    place[i] = static_cast<std::size_t>(found - header.begin());
  }
  const char* separator = "";
  for (const char* name : kInputs) std::cout << std::exchange(separator, ",") << name;
  for (const char* name : kResults) std::cout << ',' << name;
  std::cout << '\n';
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (line.empty()) continue;
    try {
      const auto cells = cells_of(line);
      Inputs inputs;
      for (std::size_t i = 0; i < kInputs.size(); ++i) {
        if (place[i] >= cells.size()) throw std::runtime_error(std::string(kInputs[i]) + " is missing");
        inputs[i] = number_in(cells[place[i]], kInputs[i]);
      }
      const Results results = compute(inputs);
      print(std::cout, inputs, true);
      print(std::cout, results, false);
      std::cout << '\n';
    } catch (const std::exception& wrong) {
      throw std::runtime_error(file + ':' + std::to_string(number) + ": " + wrong.what());
    }
  }
}

}  // namespace

void add_contact(CLI::App& app, const offline::Common& /*common*/) {
  auto* command = app.add_subcommand(
      "contact", "print the Hertz and Cattaneo-Mindlin solution for each row of a CSV file");
  auto file = std::make_shared<std::string>();
  command
      ->add_option("file", *file,
                   "CSV file with the columns P_N, mu, R1_m, E1_Pa, nu1, R2_m (inf: flat), E2_Pa, nu2, "
                   "one_minus_gamma (Q/(mu P)), s (r/a)")
      ->required();
  command->callback([file] { run(*file); });
}

}  // namespace sliplab
