#pragma once

#include "core/contact/skin_base.hpp"

namespace offline {

// As the key skin.base has it: static storage.
constexpr const char* name_of(slipd::SkinBase base) noexcept {
  return base == slipd::SkinBase::rigid ? "rigid" : "half_space";
}

}  // namespace offline
