#include "lab/paper/figures.hpp"

#include <sstream>

#include "tools/offline/gnuplot.hpp"

namespace lab {
namespace {

constexpr const char* kFigure3 = R"(set terminal svg size 900,700 font 'sans,14' background 'white'
set output 'figure3.svg'
set datafile separator ','
set title "Columns of X_{/Symbol a} on the first three bases"
set xlabel 'u_1' ; set ylabel 'u_2' ; set zlabel 'u_3'
set cblabel 'safety margin' ; set cbrange [0:1]
set palette defined (0 '#b2182b', 0.5 '#fddbc7', 1 '#2166ac')
set view 62,325
splot 'figure3.csv' every 4::1 using 1:2:3:4 with points palette pointtype 7 pointsize 0.35 notitle
)";

constexpr const char* kFigure4 = R"(set terminal svg size 900,600 font 'sans,14' background 'white'
set output 'figure4.svg'
set datafile separator ','
set title 'Five classes of the safety margin, 5 nearest neighbours'
set xlabel 'number of bases' ; set ylabel 'test accuracy, %'
$paper << end
3,81
8,91
end
set logscale x ; set xrange [1:100] ; set yrange [30:100]
set xtics (1,2,3,5,8,10,20,50,100) ; set grid ; set key bottom right
set style fill transparent solid 0.35 noborder
plot 'figure4.csv' every ::1 using 1:3:4 with filledcurves fillcolor '#6baed6' notitle, \
     '' every ::1 using 1:6:7 with filledcurves fillcolor '#fdae6b' notitle, \
     '' every ::1 using 1:8 with lines linecolor '#2171b5' dashtype 2 title 'full columns, split at random', \
     '' every ::1 using 1:9 with lines linecolor '#d94801' dashtype 2 title 'full columns, by contact', \
     '' every ::1 using 1:2 with linespoints linecolor '#2171b5' linewidth 2 pointtype 7 title 'split at random', \
     '' every ::1 using 1:5 with linespoints linecolor '#d94801' linewidth 2 pointtype 5 title 'split by contact', \
     $paper using 1:2 with points pointtype 2 pointsize 1.8 linewidth 3 linecolor 'black' title 'the paper'
)";

std::string figure3_csv(const Experiment& experiment) {
  std::ostringstream csv;
  csv << "u1_rad,u2_rad,u3_rad,gamma\n";
  const Eigen::MatrixXf points = projections(experiment);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    csv << points(0, j) << ',' << points(1, j) << ',' << points(2, j) << ',' << points(3, j) << '\n';
  }
  return csv.str();
}

std::string figure4_csv(const Row& row) {
  std::ostringstream csv;
  csv << "bases,random,random_low,random_high,by_contact,by_contact_low,by_contact_high,columns_random,"
         "columns_by_contact\n";
  const Outcome& first = row.outcomes.front();
  const auto put = [&](const Spread& spread) {
    csv << ',' << 100 * spread.mean << ',' << 100 * spread.low << ',' << 100 * spread.high;
  };
  for (std::size_t b = 0; b < first.random.size(); ++b) {
    csv << row.experiment.bases[b];
    put(spread_of(row, [&](const Outcome& o) { return o.random[b]; }));
    if (b < first.by_contact.size())
      put(spread_of(row, [&](const Outcome& o) { return o.by_contact[b]; }));
    else
      csv << ",,,";
    csv << ',' << 100 * spread_of(row, [](const Outcome& o) { return o.random_columns; }).mean << ','
        << 100 * spread_of(row, [](const Outcome& o) { return o.by_contact_columns; }).mean << '\n';
  }
  return csv.str();
}

}  // namespace

void write_figures(const std::filesystem::path& folder, const Row& row) {
  std::filesystem::create_directories(folder);
  offline::write_file(folder / "figure3.csv", figure3_csv(row.experiment));
  offline::write_file(folder / "figure4.csv", figure4_csv(row));
  offline::plot(folder, "figure3", kFigure3);
  offline::plot(folder, "figure4", kFigure4);
}

}  // namespace lab
