#include "lab/noise_options.hpp"

#include <CLI/CLI.hpp>
#include <string>

namespace lab {

using slipd::NoiseKind;

const char* name_of(NoiseKind kind) noexcept {
  return kind == NoiseKind::relative ? "relative" : "sensor";
}

void add_noise_options(CLI::App& command, double& fraction, NoiseKind& kind) {
  command.add_option("--noise", fraction, "half-width of the uniform noise, as a fraction: see --noise-kind")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
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
