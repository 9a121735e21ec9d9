#include "tests/support/devices/contacts.hpp"

namespace slipd::devices {

std::vector<Contact> pattern(const Sheet& sheet) {
  std::vector<Contact> contacts;
  for (std::size_t sensor = 0; sensor < sheet.sensors; ++sensor) {
    contacts.push_back([sensor](FrameSlot& slot) {
      for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
        slot.normal_pa[i] = 1000 * static_cast<float>(i + 1) + 100 * static_cast<float>(sensor);
        slot.shear_x_pa[i] = slot.normal_pa[i] / 2;
        slot.shear_y_pa[i] = -slot.normal_pa[i] / 4;
      }
      slot.truth = {};
    });
  }
  return contacts;
}

}  // namespace slipd::devices
