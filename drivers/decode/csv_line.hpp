// A line of numbers in text, as many microcontrollers print them: "12.5, -3, 1e-2". Pure; acquire thread;
// allocates nothing, and knows no locale.
#pragma once

#include <cstdint>
#include <span>

namespace slipd::decode {

// Fills `to` with the numbers as little-endian doubles, in order. Numbers are separated by commas,
// semicolons, blanks or tabs. False where the line has not just as many as `to` has room for, or something
// else.
bool numbers_of_line(std::span<const std::uint8_t> line, std::span<std::uint8_t> to) noexcept;

}  // namespace slipd::decode
