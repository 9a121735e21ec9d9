// slipd without hardware: a box in MuJoCo, in a gripper whose pads send frames to slipd and whose force
// follows slipd's advice.
//   hold GRIPPER.XML [deaf] [SOCKET]
// The box is gripped with 4 N, its support sinks, and twice friction falls. deaf: the force stays, whatever
// slipd says. Ends with 0 if the box was held, with 1 if it fell.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <slipd.hpp>
#include <stdexcept>
#include <string>
#include <thread>

namespace {

constexpr int kTaxels = 16;
constexpr double kFrameS = 0.01;  // of the sensors
constexpr double kGripN = 4;      // of each finger, at first
constexpr double kMostN = 12;
constexpr double kShareMore = 1.1;  // on an alert without advice
constexpr double kEndS = 8;
constexpr double kFallenM = 0.02;
constexpr double kMaxAgeS = 1;  // the box waits for slipd, so that a busy machine stretches its time

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Model loaded(const char* file) {
  char error[512] = "";
  Model model(mj_loadXML(file, nullptr, error, sizeof error), mj_deleteModel);
  if (!model) throw std::runtime_error(error);
  return model;
}

// What time it is for the box: how much of its weight the fingers carry, and its friction.
double carried(double time_s) {
  return std::clamp(time_s - 1, 0.0, 1.0);
}
double friction(double time_s) {
  return time_s < 3.5 ? 0.8 : time_s < 5.5 ? 0.5 : 0.35;
}

// A finger's frame: the forces of its pillars' springs, N, of each pillar x, y and z.
std::array<float, 3 * kTaxels> frame(const mjModel& model, const mjData& data, const char* finger) {
  std::array<float, 3 * kTaxels> values{};
  const int first = mj_name2id(&model, mjOBJ_BODY, finger) + 1;  // pillars follow their finger
  for (int taxel = 0; taxel < kTaxels; ++taxel) {
    const int joint = model.body_jntadr[first + taxel];
    for (const int axis : {1, 2, 0})
      values[static_cast<std::size_t>(3 * taxel + (axis + 2) % 3)] =
          static_cast<float>(model.jnt_stiffness[joint + axis] * data.qpos[model.jnt_qposadr[joint + axis]]);
  }
  return values;
}

// The force after an estimate: more where slipd begins to warn or sees the box slide. It never lets go by
// itself.
double next_force(double force_n, const slipd_estimate& now, int alert_before) {
  const bool slides = now.sliding == SLIPD_SLIDING_TRANSLATION || now.sliding == SLIPD_SLIDING_ROTATION;
  const bool alerted = now.alert == SLIPD_ALERT_WARN || now.alert == SLIPD_ALERT_SLIP;
  if (!slides && !(alerted && now.alert != alert_before)) return force_n;
  // A grasp's advice is for all its fingers together.
  const double more_n = std::isfinite(now.grip_increase_n) ? now.grip_increase_n / 2 : 0;
  return std::min(kMostN, std::max(force_n + more_n, force_n * kShareMore));
}

int run(const char* file, bool deaf, const std::string& socket) {
  const Model model = loaded(file);
  const Data data(mj_makeData(model.get()), mj_deleteData);
  const auto box = static_cast<std::ptrdiff_t>(mj_name2id(model.get(), mjOBJ_BODY, "object"));
  slipd_frames frames{};
  frames.taxels = kTaxels;
  frames.axes = 3;
  frames.unit = SLIPD_UNIT_N;
  slipd::client::Source left("left", frames, socket), right("right", frames, socket);
  slipd::client::Connection slipd(socket);
  slipd.attach("gripper");
  double force_n = kGripN, least = 1;
  int alert = SLIPD_ALERT_NONE;
  auto due = std::chrono::steady_clock::now();
  for (int sent = 1; data->time < kEndS; ++sent) {
    while (data->time < sent * kFrameS) {
      model->opt.gravity[2] = -9.81 * carried(data->time);
      for (int i = 0; i < model->ngeom; ++i)
        model->geom_friction[3 * static_cast<std::ptrdiff_t>(i)] = friction(data->time);
      data->ctrl[0] = data->ctrl[1] = force_n;
      mj_step(model.get(), data.get());
    }
    left.push(frame(*model, *data, "left"));
    right.push(frame(*model, *data, "right"));
    const slipd::client::Estimate now = slipd.wait("gripper", kMaxAgeS, kMaxAgeS);
    const double fell_mm = -1e3 * data->xpos[3 * box + 2];
    if (sent % 10 == 0)
      std::printf("%5.2f s  friction %.2f  %-10s margin %5.2f  force %4.1f N  fell %5.1f mm\n", data->time,
                  friction(data->time), slipd_state_name(now.fields().state), now.margin().value_or(NAN),
                  force_n, fell_mm);
    least = std::min(least, now.margin().value_or(1));
    if (fell_mm > 1e3 * kFallenM) return std::printf("fell, at %.2f s with %.1f N\n", data->time, force_n), 1;
    if (!deaf) force_n = next_force(force_n, now.fields(), alert);
    alert = now.fields().alert;
    std::this_thread::sleep_until(due += std::chrono::milliseconds(10));
  }
  return std::printf("held, with %.1f N in the end; the least margin that slipd told was %.2f\n", force_n,
                     least),
         0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: hold GRIPPER.XML [deaf] [SOCKET]\n"), 2;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // each line at once, also into a pipe
  const bool deaf = argc > 2 && std::strcmp(argv[2], "deaf") == 0;
  try {
    return run(argv[1], deaf, argc > 2 + deaf ? argv[2 + deaf] : "/tmp/slipd-mujoco.sock");
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "hold: %s\n", error.what()), 2;
  }
}
