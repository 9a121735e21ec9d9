#include "lab/torque/grasp.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/contact/averages.hpp"
#include "core/contact/hertz.hpp"

namespace lab {
namespace {

using namespace slipd;

// T_max of Hertz over mu P a: the torque that weighs as much as a pull in a mixture.
constexpr double kTurnLever = 3 * std::numbers::pi / 16;

constexpr std::size_t kClosing = 30, kLoading = 80, kMoving = 40, kMovesMore = 5;  // frames; moves

// Which of the stream's numbers.
enum Draw : std::uint64_t { mix, sign, toward, share, first_move };

MixedLoad draw_mixture(Mix of, const RandomStream& random) {
  MixedLoad load;
  load.toward_rad = random.uniform(Draw::toward, 0, 2 * std::numbers::pi);
  if (of == Mix::both) load.mix_rad = random.uniform(Draw::mix, 0.15, 1.3);
  if (of == Mix::turn) load.mix_rad = random.uniform(Draw::mix, 1.3, std::numbers::pi / 2);
  if (random.uniform(Draw::sign) < 0.5) load.mix_rad = -load.mix_rad;
  return load;
}

TurningMove draw_move(TurningMove last, const RandomStream& random) {
  enum class Kind : std::uint8_t { mixture, fall, reversal, regrip, rise };
  last.frames = kMoving;
  switch (static_cast<Kind>(std::min(4.0, std::floor(random.uniform(0, 0, 5))))) {
    case Kind::mixture:
      last.load.mix_rad = random.uniform(1, -1.4, 1.4);
      last.load.toward_rad += random.uniform(2, -0.8, 0.8);
      break;
    case Kind::fall:
      last.load.share *= random.uniform(1, 0.2, 0.8);
      break;
    case Kind::reversal:
      last.load.mix_rad = -last.load.mix_rad;
      break;
    case Kind::regrip:
      last.normal_n *= random.uniform(1, 1.1, 1.6);
      last.load.share /= 1.4;
      break;
    case Kind::rise:
      last.load.share = random.uniform(1, 0.7, 1.0);
      break;
  }
  return last;
}

}  // namespace

std::vector<TurningMove> draw_moves(const ContactDraw& contact, Course course, Mix mix,
                                    const RandomStream& random) {
  MixedLoad load = draw_mixture(mix, random);
  if (course == Course::frame) {
    load.share = random.uniform(Draw::share, 0.05, 1);
    return {{1, contact.normal_n, {}}, {1, contact.normal_n, load}};
  }
  load.share = course == Course::ramp ? 1 : random.uniform(Draw::share, 0.5, 0.95);
  std::vector<TurningMove> moves{{kClosing, contact.normal_n, {}}, {kLoading, contact.normal_n, load}};
  for (std::size_t i = 0; course == Course::history && i < kMovesMore; ++i)
    moves.push_back(draw_move(moves.back(), random.stream(Draw::first_move + i)));
  return moves;
}

TurningGrasp::TurningGrasp(const ContactDraw& contact, const Skin& skin, const TaxelLayout& layout,
                           double noise, const RandomStream& random)
    : layout_(layout),
      contact_(contact),
      noise_(noise),
      random_(random),
      pull_(contact::make_body_pair(contact::body_of(skin),
                                    {contact.radius_m, contact.modulus_pa, contact.poisson})),
      turning_(pull_.pair()),
      hertz_(contact::unit_hertz_surface()),
      normal_pa_(layout.size()),
      x_pa_(layout.size()),
      y_pa_(layout.size()),
      felt_normal_pa_(layout.size()),
      felt_x_pa_(layout.size()),
      felt_y_pa_(layout.size()) {}

contact::PlaneLoad TurningGrasp::load_of(const TurningMove& move) const {
  const double pull = std::cos(move.load.mix_rad), turn = kTurnLever * std::sin(move.load.mix_rad);
  const double unit_n =
      contact_.friction * move.normal_n * move.load.share / hertz_.least_friction(pull, 0, turn).ratio;
  return {unit_n * pull * std::cos(move.load.toward_rad), unit_n * pull * std::sin(move.load.toward_rad),
          unit_n * turn * pull_.pair().contact_radius_m(move.normal_n)};
}

// A pull alone has the exact tractions of LoadHistory, along x and turned afterwards.
void TurningGrasp::apply(double normal_n, const contact::PlaneLoad& load) {
  normal_n_ = normal_n;
  load_ = load;
  if (turning_.active() || load.torque_nm != 0) {
    if (!turning_.active()) turning_.begin(pull_);
    turning_.move_to(normal_n, load, contact_.friction);
    return;
  }
  pull_.move_to(normal_n, std::hypot(load.shear_x_n, load.shear_y_n), contact_.friction);
}

Frame TurningGrasp::feel() {
  if (turning_.active()) {
    turning_.taxel_averages(layout_, contact_.x_m, contact_.y_m, normal_pa_, x_pa_, y_pa_);
  } else {
    contact::taxel_averages(layout_, contact_.x_m, contact_.y_m, pull_, normal_pa_, x_pa_);
    const double shear_n = std::max(1e-300, std::hypot(load_.shear_x_n, load_.shear_y_n));
    for (std::size_t i = 0; i < x_pa_.size(); ++i) {
      y_pa_[i] = static_cast<float>(load_.shear_y_n / shear_n) * x_pa_[i];
      x_pa_[i] *= static_cast<float>(load_.shear_x_n / shear_n);
    }
  }
  const auto width = static_cast<float>(noise_) * *std::max_element(normal_pa_.begin(), normal_pa_.end());
  const RandomStream noise = random_.stream(++sequence_);
  std::uint64_t channel = 0;
  for (auto [felt, from] : {std::pair{&felt_normal_pa_, &normal_pa_}, std::pair{&felt_x_pa_, &x_pa_},
                            std::pair{&felt_y_pa_, &y_pa_}}) {
    *felt = *from;
    noise.stream(channel++).add_noise(felt->data(), felt->size(), width);
  }
  return {sequence_, static_cast<std::int64_t>(sequence_) * 1'000'000, felt_normal_pa_, felt_x_pa_,
          felt_y_pa_};
}

Truth TurningGrasp::truth() const {
  return {turning_.active() ? turning_.safety_margin() : pull_.safety_margin(), contact_.friction};
}

}  // namespace lab
