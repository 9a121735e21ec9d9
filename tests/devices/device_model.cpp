#include "tests/devices/device_model.hpp"

#include <algorithm>

namespace slipd::devices {

std::vector<const DeviceModel*> all_models() {
  return {&xela_xr1944(),   &icub_skin(),     &takktile(),  &papillarray(), &robotiq_tsf85(), &vendor_hid(),
          &onrobot_rg2ft(), &robotiq_ft300(), &optoforce(), &space_mouse(), &rohand(),        &hid_force()};
}

const DeviceModel* find_model(std::string_view name) {
  const auto models = all_models();
  const auto found = std::ranges::find(models, name, [](const DeviceModel* model) { return model->name; });
  return found == models.end() ? nullptr : *found;
}

}  // namespace slipd::devices
