// slipd --list-drivers: every module, what it is for, and its options, from the module's own schema.
#pragma once

#include <iosfwd>

#include "daemon/pipeline/modules.hpp"

namespace slipd {

// False if a module that is there cannot be used; why is printed in its place.
bool list_drivers(DriverModules& drivers, std::ostream& out);

}  // namespace slipd
