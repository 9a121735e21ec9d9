#include "lab/grip/world.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <stdexcept>

namespace lab::grip {
namespace {

// How far the fingers are from the object at the beginning, m.
constexpr double kGap = 0.002;
constexpr double kTipRadius = 0.0008;
// Share of the normal force that slides where all does.
constexpr double kAll = 0.995;

void write_pad(std::ostream& out, Side side, const WorldOptions& o) {
  const bool left = side == Side::left;
  const char* const name = left ? "left" : "right";
  const double inward = left ? 1 : -1;
  for (int row = 0; row < o.side; ++row) {
    for (int column = 0; column < o.side; ++column) {
      const double sx = (column - 0.5 * (o.side - 1)) * o.pitch_m,
                   sy = (row - 0.5 * (o.side - 1)) * o.pitch_m;
      const double sag = (sx * sx + sy * sy) / (2 * o.dome_radius_m);
      out << "<body pos='" << -inward * (sag + kTipRadius) << ' ' << inward * sx << ' ' << sy << "'>"
          << "<inertial pos='0 0 0' mass='0.0002' diaginertia='1e-9 1e-9 1e-9'/>"
          << "<joint class='normal' axis='" << -inward << " 0 0'/>"
          << "<joint class='shear' axis='0 " << inward << " 0'/>"
          << "<joint class='shear' axis='0 0 1'/>"
          << "<geom name='" << name << row * o.side + column << "' class='tip'/></body>\n";
    }
  }
}

void write_finger(std::ostream& out, Side side, double half_width_m, const WorldOptions& o) {
  const bool left = side == Side::left;
  const double inward = left ? 1 : -1;
  out << "<body name='" << (left ? "left" : "right") << "' pos='" << -inward * (half_width_m + kGap)
      << " 0 0'>"
      << "<inertial pos='0 0 0' mass='0.1' diaginertia='1e-4 1e-4 1e-4'/>"
      << "<joint name='" << (left ? "left" : "right") << "' type='slide' axis='" << inward
      << " 0 0' damping='40'/>\n";
  write_pad(out, side, o);
  out << "</body>\n";
}

void write_object(std::ostream& out, const Task& task) {
  const double r = task.half_width_m, m = task.mass_kg;
  const double spin = 0.4 * m * 0.03 * 0.03;  // of a ball of 3 cm
  out << "<body name='object'><freejoint/><inertial pos='" << task.center_m[0] << ' ' << task.center_m[1]
      << ' ' << task.center_m[2] << "' mass='" << m << "' diaginertia='" << spin << ' ' << spin << ' ' << spin
      << "'/>";
  switch (task.shape) {
    case Shape::box:
      out << "<geom class='object' type='box' size='" << r << " 0.03 0.03'/>";
      break;
    case Shape::cylinder:
      out << "<geom class='object' type='cylinder' size='" << r << " 0.03'/>";
      break;
    case Shape::sphere:
      out << "<geom class='object' type='sphere' size='" << r << "'/>";
      break;
  }
  out << "</body>\n";
}

std::string text_of(const Task& task, const WorldOptions& o) {
  std::ostringstream out;
  // Armature: pillars of 0.2 g on such springs would swing faster than the step.
  out << "<mujoco><size njmax='1000' nconmax='400'/><option timestep='" << o.step_s
      << "' gravity='0 0 0' cone='elliptic' solver='Newton' iterations='30' tolerance='1e-10' "
         "jacobian='sparse' noslip_iterations='"
      << o.noslip_iterations << "'/>"
      << "<default><default class='normal'><joint type='slide' armature='0.003' stiffness='"
      << o.normal_stiffness
      << "' damping='1.7'/></default><default class='shear'><joint type='slide' armature='0.003' stiffness='"
      << o.shear_stiffness << "' damping='1.3'/></default>"
      << "<default class='tip'><geom type='sphere' size='" << kTipRadius
      << "' contype='2' conaffinity='1' condim='3' solref='0.005 1' solimp='0.95 0.99 0.0002'/></default>"
      << "<default class='object'><geom contype='1' conaffinity='2' condim='3' solref='0.005 1' solimp='0.95 "
         "0.99 0.0002'/></default>"
      << "</default><worldbody>\n";
  write_object(out, task);
  write_finger(out, Side::left, task.half_width_m, o);
  write_finger(out, Side::right, task.half_width_m, o);
  out << "</worldbody><equality><joint joint1='left' joint2='right' polycoef='0 1 0 0 0' solref='0.005 "
         "1'/></equality>"
      << "<actuator><motor joint='left'/><motor joint='right'/></actuator></mujoco>";
  return out.str();
}

mjModel* model_of(const std::string& text) {
  mjVFS files;
  mj_defaultVFS(&files);
  mj_makeEmptyFileVFS(&files, "world.xml", static_cast<int>(text.size()));
  std::memcpy(files.filedata[mj_findFileVFS(&files, "world.xml")], text.data(), text.size());
  char error[512] = "";
  mjModel* const model = mj_loadXML("world.xml", &files, error, sizeof error);
  mj_deleteVFS(&files);
  if (model == nullptr) throw std::runtime_error(std::string("MuJoCo refuses the gripper: ") + error);
  return model;
}

}  // namespace

// Of what MuJoCo allocates.
struct Deletes {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

struct World::State {
  WorldOptions options;
  std::unique_ptr<mjModel, Deletes> model;
  std::unique_ptr<mjData, Deletes> data;
  std::ptrdiff_t object = 0;
  std::array<double, 3> begun{};

  void step(mjData* d, double grip_n, const std::array<double, 3>& load_n, double friction) const {
    for (std::ptrdiff_t i = 0; i < model->ngeom; ++i) model->geom_friction[3 * i] = friction;
    d->ctrl[0] = d->ctrl[1] = grip_n;
    std::copy(load_n.begin(), load_n.end(), d->xfrc_applied + 6 * object);
    mj_step(model.get(), d);
  }
  bool is_left(const mjContact& contact) const {
    const int bodies = model->geom_bodyid[contact.geom1] == object ? contact.geom2 : contact.geom1;
    return model->body_parentid[model->geom_bodyid[bodies]] == mj_name2id(model.get(), mjOBJ_BODY, "left");
  }
  // Of each side the normal force of all contacts, of those that slide, and of the one that carries most of
  // those that stick.
  struct Sums {
    std::array<double, 2> all{}, sliding{}, pivot{};

    // A body that two pillars hold cannot move along the pad; about a single one it turns.
    bool slides(bool or_turns) const {
      const auto slides = [&](std::size_t side) {
        return sliding[side] + (or_turns ? pivot[side] : 0) >= kAll * all[side];
      };
      return slides(0) && slides(1);
    }
    double sliding_share() const {
      const double both = all[0] + all[1];
      return both > 0 ? (sliding[0] + sliding[1]) / both : 1;
    }
  };
  Sums sums(const mjData* d) const {
    constexpr double kOnTheCone = 0.98;
    Sums sums;
    for (int i = 0; i < d->ncon; ++i) {
      const mjContact& contact = d->contact[i];
      if (contact.efc_address < 0) continue;
      mjtNum force[6];
      mj_contactForce(model.get(), d, i, force);
      const auto side = static_cast<std::size_t>(is_left(contact) ? 0 : 1);
      sums.all[side] += force[0];
      if (std::hypot(force[1], force[2]) >= kOnTheCone * contact.friction[0] * force[0])
        sums.sliding[side] += force[0];
      else
        sums.pivot[side] = std::max(sums.pivot[side], force[0]);
    }
    return sums;
  }
};

World::World(const Task& task, const WorldOptions& options) : state_(std::make_unique<State>()) {
  state_->options = options;
  state_->model.reset(model_of(text_of(task, options)));
  state_->data.reset(mj_makeData(state_->model.get()));
  state_->object = mj_name2id(state_->model.get(), mjOBJ_BODY, "object");
  mj_forward(state_->model.get(), state_->data.get());
  std::copy_n(state_->data->xipos + 3 * state_->object, 3, state_->begun.begin());
}

World::~World() = default;
World::World(World&&) noexcept = default;

void World::step(double grip_n, const std::array<double, 3>& load_n, double friction) {
  state_->step(state_->data.get(), grip_n, load_n, friction);
}

double World::time_s() const {
  return state_->data->time;
}

void World::read(Side side, std::vector<float>& values) const {
  const mjModel& m = *state_->model;
  const auto side_taxels = static_cast<std::size_t>(state_->options.side);
  const std::size_t taxels = side_taxels * side_taxels;
  values.resize(3 * taxels);
  const char* const name = side == Side::left ? "left0" : "right0";
  const int first_body = m.geom_bodyid[mj_name2id(&m, mjOBJ_GEOM, name)];
  for (std::size_t i = 0; i < taxels; ++i) {
    const int joint = m.body_jntadr[first_body + static_cast<int>(i)];
    const auto force = [&](int axis) {
      return static_cast<float>(m.jnt_stiffness[joint + axis] *
                                state_->data->qpos[m.jnt_qposadr[joint + axis]]);
    };
    values[3 * i] = force(1);
    values[3 * i + 1] = force(2);
    values[3 * i + 2] = force(0);
  }
}

std::array<double, 3> World::moved_m() const {
  std::array<double, 3> moved{};
  for (std::size_t i = 0; i < 3; ++i)
    moved[i] = state_->data->xipos[3 * state_->object + static_cast<std::ptrdiff_t>(i)] - state_->begun[i];
  return moved;
}

double World::normal_n() const {
  const State::Sums sums = state_->sums(state_->data.get());
  return 0.5 * (sums.all[0] + sums.all[1]);
}

bool World::slides() const {
  return state_->sums(state_->data.get()).slides(false);
}

double World::width_m() const {
  const auto& d = *state_->data;
  const auto& m = *state_->model;
  const std::ptrdiff_t left = mj_name2id(&m, mjOBJ_BODY, "left"), right = mj_name2id(&m, mjOBJ_BODY, "right");
  return d.xpos[3 * right] - d.xpos[3 * left];
}

struct World::Moment::Copy {
  std::unique_ptr<mjData, Deletes> data;
  double friction = 0;
};

World::Moment::Moment(const State& state)
    : copy_(std::make_unique<Copy>(
          Copy{std::unique_ptr<mjData, Deletes>(mj_copyData(nullptr, state.model.get(), state.data.get())),
               state.model->geom_friction[0]})) {}
World::Moment::~Moment() = default;
World::Moment::Moment(Moment&&) noexcept = default;

World::Moment World::moment() const {
  return Moment(*state_);
}

// A pillar near the point that the object turns about slips only after a large turn. For the load not to
// outrun that, it grows the more slowly, the more slides.
TrueMargins World::true_margins(const Moment& moment) const {
  // In these times it grows by e, s: while all sticks, and while nearly all slides.
  constexpr double kSticking = 0.3, kSliding = 10;
  constexpr double kMostFactor = 50, kNoLoadN = 1e-6;
  mjData* const d = moment.copy_->data.get();
  mjtNum* const load = d->xfrc_applied + 6 * state_->object;
  const mjtNum* const center = d->xipos + 3 * state_->object;
  const std::array<double, 3> load_n{load[0], load[1], load[2]}, begun_m{center[0], center[1], center[2]};
  TrueMargins out;
  if (std::hypot(load_n[0], load_n[1], load_n[2]) < kNoLoadN) return out;
  const double grip_n = d->ctrl[0];
  double growth = 0;  // the logarithm of the factor
  bool turns = false;
  while (growth < std::log(kMostFactor)) {
    const State::Sums sums = state_->sums(d);
    if (!turns && sums.slides(true)) {
      turns = true;
      out.until_turning = -std::expm1(-growth);
    }
    if (sums.slides(false)) {
      out.until_sliding = -std::expm1(-growth);
      break;
    }
    growth += state_->options.step_s / (kSticking + kSliding * sums.sliding_share());
    // Its torque about the grip grows with it, however far the object has moved by now.
    const double factor = std::exp(growth);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      load[3 + i] = factor * ((begun_m[j] - center[j]) * load_n[k] - (begun_m[k] - center[k]) * load_n[j]);
    }
    state_->step(d, grip_n, {factor * load_n[0], factor * load_n[1], factor * load_n[2]},
                 moment.copy_->friction);
  }
  return out;
}

}  // namespace lab::grip
