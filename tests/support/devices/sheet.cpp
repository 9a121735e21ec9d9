#include "tests/support/devices/sheet.hpp"

#include <algorithm>

namespace slipd::devices {

std::vector<const Sheet*> all_sheets() {
  return {&xela_xr1944(),   &icub_skin(),     &takktile(),  &papillarray(), &robotiq_tsf85(), &vendor_hid(),
          &onrobot_rg2ft(), &robotiq_ft300(), &optoforce(), &space_mouse(), &rohand(),        &hid_force()};
}

const Sheet* find_sheet(std::string_view name) {
  const auto sheets = all_sheets();
  const auto found = std::ranges::find(sheets, name, [](const Sheet* sheet) { return sheet->name; });
  return found == sheets.end() ? nullptr : *found;
}

}  // namespace slipd::devices
