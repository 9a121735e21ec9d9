#include "lab/frames/torque_frames.hpp"

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
struct Draw {
  enum : std::uint64_t { mix, sign, toward, share, first_move };
};

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

const char* name_of(Mix mix) noexcept {
  static constexpr const char* kNames[] = {"pull", "both", "turn"};
  return kNames[static_cast<std::size_t>(mix)];
}

const char* name_of(Course course) noexcept {
  static constexpr const char* kNames[] = {"frame", "ramp", "history"};
  return kNames[static_cast<std::size_t>(course)];
}

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

TorqueFrames::TorqueFrames(const ContactDraw& contact, const Skin& skin, const TaxelLayout& layout,
                           double noise, const RandomStream& random, std::vector<TurningMove> moves)
    : layout_(layout),
      contact_(contact),
      random_(random),
      moves_(std::move(moves)),
      pull_(contact::make_body_pair(contact::body_of(skin),
                                    {contact.radius_m, contact.modulus_pa, contact.poisson})),
      turning_(pull_.pair()),
      hertz_(contact::unit_hertz_surface()),
      frames_(layout, NoiseKind::sensor, noise) {}

contact::PlaneLoad TorqueFrames::load_of(const TurningMove& move) const {
  const double pull = std::cos(move.load.mix_rad), turn = kTurnLever * std::sin(move.load.mix_rad);
  const double unit_n =
      contact_.friction * move.normal_n * move.load.share / hertz_.least_friction(pull, 0, turn).ratio;
  return {unit_n * pull * std::cos(move.load.toward_rad), unit_n * pull * std::sin(move.load.toward_rad),
          unit_n * turn * pull_.pair().contact_radius_m(move.normal_n)};
}

// A pull alone has the exact tractions of LoadHistory, along x and turned afterwards.
void TorqueFrames::apply(double normal_n, const contact::PlaneLoad& load) {
  load_ = load;
  moment_.normal_n = normal_n;
  moment_.shear_n = std::hypot(load.shear_x_n, load.shear_y_n);
  if (turning_.active() || load.torque_nm != 0) {
    if (!turning_.active()) turning_.begin(pull_);
    turning_.move_to(normal_n, load, contact_.friction);
    return;
  }
  pull_.move_to(normal_n, moment_.shear_n, contact_.friction);
}

bool TorqueFrames::next() {
  while (step_ == steps_) {
    if (begun_ == moves_.size()) return false;
    step_ = 0;
    steps_ = moves_[begun_].frames;
    from_normal_n_ = moment_.normal_n;
    from_ = load_;
    to_ = load_of(moves_[begun_++]);
  }
  const double part = static_cast<double>(++step_) / static_cast<double>(steps_);
  const auto at = [part](double from, double to) { return from + part * (to - from); };
  apply(at(from_normal_n_, moves_[begun_ - 1].normal_n),
        {at(from_.shear_x_n, to_.shear_x_n), at(from_.shear_y_n, to_.shear_y_n),
         at(from_.torque_nm, to_.torque_nm)});
  constexpr double kFrameS = 0.001;
  ++moment_.number;
  moment_.time_s = kFrameS * static_cast<double>(moment_.number);
  moment_.move = begun_ - 1;
  moment_.truth = {turning_.active() ? turning_.safety_margin() : pull_.safety_margin(), contact_.friction};
  return true;
}

void TorqueFrames::fill_taxels() {
  const auto normal = frames_.normal_pa(), x = frames_.sensed_shear_x_pa(), y = frames_.sensed_shear_y_pa();
  if (turning_.active()) {
    turning_.taxel_averages(layout_, contact_.x_m, contact_.y_m, normal, x, y);
    return;
  }
  contact::taxel_averages(layout_, contact_.x_m, contact_.y_m, pull_, normal, x);
  const double shear_n = std::max(1e-300, moment_.shear_n);
  for (std::size_t i = 0; i < x.size(); ++i) {
    y[i] = static_cast<float>(load_.shear_y_n / shear_n) * x[i];
    x[i] *= static_cast<float>(load_.shear_x_n / shear_n);
  }
}

FrameSlot& TorqueFrames::sense() {
  fill_taxels();
  frames_.sense_plane(random_.stream(moment_.number));
  slot_ = slot_of(frames_, static_cast<std::int64_t>(moment_.number) * 1'000'000);
  return slot_;
}

}  // namespace lab
