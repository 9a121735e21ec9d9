#include "core/chain/contact_pipeline.hpp"

#include <stdexcept>

#include "core/chain/chain_parts.hpp"
#include "core/chain/force_pipelines.hpp"
#include "core/chain/setup/sensor_kind.hpp"
#include "core/chain/shaped_pipelines.hpp"

namespace slipd {

std::unique_ptr<ContactPipeline> make_pipeline(const ChainSetup& setup,
                                               const std::shared_ptr<const TrainedModel>& model,
                                               WorkPrecision& work_precision) {
  switch (kind_of(setup)) {
    case SensorKind::pressure_only:
      return std::make_unique<PressureOnlyPipeline>(setup.layout.size() > 1);
    case SensorKind::one_force:
      return std::make_unique<OneForcePipeline>(setup);
    case SensorKind::pillars:
      return std::make_unique<PillarPipeline>(setup);
    case SensorKind::flat_pad:
      if (SharingFlatPadPipeline::serves(setup)) return std::make_unique<SharingFlatPadPipeline>(setup);
      return std::make_unique<FlatPadPipeline>(setup);
    case SensorKind::few_taxels:
      return std::make_unique<FewTaxelsPipeline>(setup, make_method(setup, model, work_precision));
    case SensorKind::array:
      return std::make_unique<ArrayPipeline>(setup, make_method(setup, model, work_precision));
    case SensorKind::displacement:
      break;
  }
  throw std::invalid_argument("there is no pipeline for such a kind of sensor");
}

void publish_forces(const ContactPatch& patch, Estimate& out) noexcept {
  out.normal_n = patch.normal_n;
  out.shear_n = patch.shear_n;
  out.shear_x_n = patch.shear_x_n;
  out.shear_y_n = patch.shear_y_n;
}

void publish_place(const ContactPatch& patch, Estimate& out) noexcept {
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
}

void publish_torque(const ContactPatch& patch, Estimate& out) noexcept {
  out.torque_nm = patch.torque_nm;
  out.torque_sigma_nm = patch.torque_sigma_nm;
}

ContactPatch with_pull(const ContactPatch& patch, const EquivalentPullResult& pull) noexcept {
  ContactPatch pulled = patch;
  pulled.shear_n = pull.pull_n;
  pulled.shear_sigma_n = pull.pull_sigma_n;
  return pulled;
}

}  // namespace slipd
