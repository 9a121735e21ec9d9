// training-bench [--brief] [--write FILE]: the paper's data set, 10000 taxels x 16000 columns with its noise,
// from nothing to a search tree: columns made, singular vectors, coordinates, tree. Prints one JSON object a
// line. --write: the columns instead, one after the other as 32 bit numbers, for a peer to train on the same.
#include <sys/resource.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "paper/basis/svd.hpp"
#include "paper/dataset/fold.hpp"
#include "paper/dataset/frame_columns.hpp"
#include "paper/neighbours/neighbours.hpp"
#include "tests/bench/scenes.hpp"
#include "tests/bench/times.hpp"

namespace slipd::bench {
namespace {

using nlohmann::json;

constexpr double kPaperNoise = 0.04;
constexpr unsigned kMostThreads = 4;  // what training may use

Scene paper_scene(double noise) {
  return {.skin = {}, .objects = paper_objects(), .offset_m = 0, .noise = noise};
}

double highest_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

double seconds_since(std::int64_t begun_ns) {
  return 1e-9 * static_cast<double>(now_ns() - begun_ns);
}

void train_on(const ColumnSource& columns, const char* name) {
  const std::int64_t begun = now_ns();
  const Svd svd =
      randomized_svd(columns, {.rank = 8,
                               .tolerance = 2e-5,
                               .threads = std::clamp(std::thread::hardware_concurrency(), 1U, kMostThreads),
                               .coordinates = true});
  const double svd_s = seconds_since(begun);
  const Eigen::MatrixXf& points = svd.coordinates;
  const Neighbours tree({points.data(), points.data() + points.size()},
                        static_cast<std::size_t>(points.rows()));
  const double all_s = seconds_since(begun);
  const std::vector<double> values(svd.singular_values.begin(), svd.singular_values.end());
  std::cout << json{{"part", name},
                    {"rows", columns.rows()},
                    {"columns", columns.columns()},
                    {"seconds", all_s},
                    {"svd_s", svd_s},
                    {"passes", svd.passes},
                    {"highest_mb", highest_mb()},
                    {"singular_values", values},
                    {"points", tree.size()}}
                   .dump()
            << std::endl;
}

// Columns that are there when training begins, as a peer's are.
class HeldColumns : public ColumnSource {
 public:
  explicit HeldColumns(const ColumnSource& made)
      : rows_(made.rows()), columns_(made.columns()), values_(rows_ * columns_) {
    made.fill(0, columns_, values_.data());
  }
  std::size_t rows() const noexcept override { return rows_; }
  std::size_t columns() const noexcept override { return columns_; }
  void fill(std::size_t first, std::size_t count, float* out) const override {
    std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(first * rows_), count * rows_, out);
  }

 private:
  std::size_t rows_, columns_;
  std::vector<float> values_;
};

void write(const ColumnSource& columns, const char* file) {
  constexpr std::size_t kAtOnce = 100;
  std::ofstream out(file, std::ios::binary);
  std::vector<float> block(columns.rows() * kAtOnce);
  for (std::size_t first = 0; first < columns.columns(); first += kAtOnce) {
    columns.fill(first, std::min(kAtOnce, columns.columns() - first), block.data());
    out.write(reinterpret_cast<const char*>(block.data()),
              static_cast<std::streamsize>(sizeof(float) * columns.rows() *
                                           std::min(kAtOnce, columns.columns() - first)));
  }
  if (!out.flush()) throw std::runtime_error(std::string("cannot write ") + file);
}

}  // namespace
}  // namespace slipd::bench

int main(int argc, char** argv) try {
  using namespace slipd;
  using namespace slipd::bench;
  const bool brief = argc > 1 && std::strcmp(argv[1], "--brief") == 0;
  const TaxelLayout layout = pad(brief ? 16 : 100);
  const FrameChoice choice{.size = brief ? DataSetSize{.contacts = 20, .loads = 10} : DataSetSize{}};
  const FrameColumns noisy(TaxelSet(layout), paper_scene(kPaperNoise), 1, choice);
  if (argc > 2 && std::strcmp(argv[1], "--write") == 0) {
    write(noisy, argv[2]);
    return 0;
  }
  train_on(noisy, "training");
  const auto folded = fold(layout);
  const FrameColumns eighth(TaxelSet(layout, *folded), paper_scene(0), 1, choice);
  train_on(eighth, "folded");
  train_on(HeldColumns(noisy), "held");  // last: it takes the memory that the others are measured without
} catch (const std::exception& error) {
  std::cerr << "training-bench: " << error.what() << '\n';
  return 1;
}
