#include "lab/paper/table.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ostream>

namespace lab {
namespace {

// In per cent: "mean (lowest … highest of the seeds)".
std::string text_of(const Spread& spread) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%5.1f (%.1f-%.1f)", 100 * spread.mean, 100 * spread.low,
                100 * spread.high);
  return text.data();
}

void line(std::ostream& out, const char* what, const char* paper, const std::string& random,
          const std::string& by_contact) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "  %-26s %-12s %-22s %s\n", what, paper, random.c_str(),
                by_contact.c_str());
  out << text.data();
}

// The paper's figures for X_alpha, per cent (its sections III.A and III.B).
const char* paper_accuracy(int bases) {
  switch (bases) {
    case 3:
      return "81";
    case 8:
      return "91";
    default:
      return bases > 8 ? "no more" : "";
  }
}

void print_variance(std::ostream& out, const Row& row, bool is_papers) {
  static constexpr std::array<const char*, 3> kNames{"variance of u1", "variance of u2", "variance of u3"};
  static constexpr std::array<const char*, 3> kPaper{"72", "11", "5"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    line(out, kNames[i], is_papers ? kPaper[i] : "",
         text_of(spread_of(row, [&](const Outcome& o) { return o.variance[i]; })), "");
  }
  for (const auto& [bases, name, paper] :
       {std::tuple{3, "first 3 together", "88"}, std::tuple{8, "first 8 together", ">95"}}) {
    const auto count = static_cast<std::size_t>(bases);
    line(out, name, is_papers ? paper : "",
         text_of(spread_of(row, [&](const Outcome& o) { return explained(o, count); })), "");
  }
}

void print_accuracy(std::ostream& out, const Row& row, bool is_papers) {
  const auto& bases = row.experiment.bases;
  const Outcome& first = row.outcomes.front();
  for (std::size_t b = 0; b < first.random.size(); ++b) {
    static constexpr std::array<int, 10> kShown{1, 2, 3, 5, 8, 9, 10, 20, 50, 100};
    if (std::find(kShown.begin(), kShown.end(), bases[b]) == kShown.end()) continue;
    const std::string name = "right on " + std::to_string(bases[b]) + (bases[b] == 1 ? " base" : " bases");
    line(out, name.c_str(), is_papers ? paper_accuracy(bases[b]) : "",
         text_of(spread_of(row, [&](const Outcome& o) { return o.random[b]; })),
         b < first.by_contact.size()
             ? text_of(spread_of(row, [&](const Outcome& o) { return o.by_contact[b]; }))
             : "");
  }
  if (row.experiment.column_tests > 0) {
    line(out, "right on full columns", is_papers ? "83" : "",
         text_of(spread_of(row, [](const Outcome& o) { return o.random_columns; })),
         text_of(spread_of(row, [](const Outcome& o) { return o.by_contact_columns; })));
  }
}

}  // namespace

void print_table(std::ostream& out, const std::vector<Row>& rows) {
  const Experiment& first = rows.front().experiment;
  out << "Per cent; mean (lowest-highest) of " << rows.front().outcomes.size() << " seeds. "
      << first.size.contacts << " contacts x " << first.size.loads << " loads, " << first.side << " x "
      << first.side
      << " taxels over 14.4 mm. Noise: uniform, on the quantity\nitself, of each column's maximum. 5 nearest "
         "of 70 % of the "
         "columns. Split by contact: no contact on both sides,\nbasis from the training contacts alone. Full "
         "columns: "
      << first.column_tests << " test columns a seed.\n";
  for (const Row& row : rows) {
    // The paper does not state its noise; 4 to 10 % agree with its figures.
    const bool is_papers = row.experiment.quantity == slipd::Quantity::alpha && row.experiment.offset_m == 0;
    out << '\n';
    line(out, row.title.c_str(), "paper", "split at random", "split by contact");
    print_variance(out, row, is_papers);
    print_accuracy(out, row, is_papers);
  }
}

}  // namespace lab
