#include "lab/options.hpp"

#include <CLI/CLI.hpp>
#include <string>

#include "lab/estimator.hpp"

namespace lab {
namespace {

using slipd::NoiseKind;

void add_noise(CLI::App& command, double& fraction, const char* about) {
  command.add_option("--noise", fraction, about)->check(CLI::Range(0.0, 1.0))->capture_default_str();
}

}  // namespace

const char* name_of(NoiseKind kind) noexcept {
  return kind == NoiseKind::relative ? "relative" : "sensor";
}

void add_grasps_option(CLI::App& command, std::size_t& grasps, const char* about) {
  command.add_option("--grasps", grasps, about)->check(CLI::Range(1, 100000))->capture_default_str();
}

void add_threads_option(CLI::App& command, unsigned& threads) {
  command.add_option("--threads", threads, "threads to compute with")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
}

void add_sides_option(CLI::App& command, std::vector<std::size_t>& sides) {
  command.add_option("--sides", sides, "taxels along each side of the pad")
      ->delimiter(',')
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
}

void add_methods_option(CLI::App& command, std::vector<std::string>& methods) {
  command.add_option("--methods", methods, "methods of the estimators")
      ->delimiter(',')
      ->check(CLI::IsMember(slipd::method_choices()))
      ->capture_default_str();
}

void add_presets_option(CLI::App& command, std::vector<std::string>& presets,
                        const std::vector<std::string>& allowed, const char* about) {
  command.add_option("--presets", presets, about)
      ->delimiter(',')
      ->check(CLI::IsMember(allowed))
      ->capture_default_str();
}

void add_frame_option(CLI::App& command, double& frame_s) {
  command.add_option("--frame-s", frame_s, "time between two frames of the sensor, s")
      ->check(CLI::Range(1e-4, 0.1))
      ->capture_default_str();
}

void add_noise_option(CLI::App& command, double& fraction) {
  add_noise(command, fraction, "half-width of the uniform noise, as a fraction of the largest pressure");
}

void add_noise_options(CLI::App& command, double& fraction, NoiseKind& kind) {
  add_noise(command, fraction, "half-width of the uniform noise, as a fraction: see --noise-kind");
  const auto set = [&kind](const std::string& name) {
    kind = name == name_of(NoiseKind::relative) ? NoiseKind::relative : NoiseKind::sensor;
  };
  command
      .add_option_function<std::string>(
          "--noise-kind", set,
          "sensor: a fraction of the largest pressure on all channels; relative: of the largest "
          "pressure on pressure, of the largest shear on shear")
      ->check(CLI::IsMember({name_of(NoiseKind::sensor), name_of(NoiseKind::relative)}))
      ->default_str(name_of(kind));
}

}  // namespace lab
