// slipd's estimates as Modbus input registers. The tables here are the only definition: the server,
// registers.csv and the tables of docs/plc.md are made of them, and a test compares. Pure. Any one thread.
//
// A register that is not known has a sentinel, never 0: 0xFFFF where the value is unsigned, 0x8000 (-32768)
// where it is signed, 0xFFFFFFFF in two registers. Values of 32 bits have their high word first, and each
// register its high byte first, as Modbus prescribes. A value beyond its range is its limit.
#pragma once

#include <slipd.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace slipd::modbus {

inline constexpr std::uint16_t kUnknown = 0xFFFF;
inline constexpr std::uint16_t kUnknownSigned = 0x8000;
inline constexpr std::uint32_t kUnknownLong = 0xFFFFFFFF;

// Rises when a register changes its meaning.
inline constexpr std::uint16_t kMapVersion = 1;
// Address of the first block, registers of a block, most blocks.
inline constexpr int kFirstBlock = 16, kBlockSize = 32, kMostBlocks = 96;
inline constexpr int kRegisters = kFirstBlock + kMostBlocks * kBlockSize;
// Period of the heartbeat register, ms.
inline constexpr std::int64_t kHeartbeatMs = 100;

// What the registers before the blocks are made of.
struct Header {
  // slipd serves, and its threads give signs of life.
  bool alive = false;
  // CLOCK_MONOTONIC of the last sign of life, ms.
  std::int64_t alive_ms = 0;
  // Blocks in use.
  int blocks = 0;
};

enum class RegisterType : std::uint8_t { u16, s16, u32 };

// One line of the table, of the header or of a block.
template <typename Source>
struct Register {
  // From the header's or the block's first register.
  int offset;
  RegisterType type;
  // Of one count; 1 for numbers without unit.
  double scale;
  // Of the scaled value; "" if it has none.
  const char* unit;
  const char* name;
  const char* meaning;
  // Scaled value; NaN: unknown.
  double (*value)(const Source& source);
};

std::span<const Register<Header>> header_registers();
std::span<const Register<slipd_estimate>> block_registers();

// Fills the header's kFirstBlock registers.
void write_header(const Header& header, std::span<std::uint16_t> registers);
// Fills a block's kBlockSize registers. An estimate whose margin has expired has none. State disconnected:
// all else is unknown but an alert that stands.
void write_block(const slipd_estimate& estimate, std::span<std::uint16_t> registers);

// Both tables: CSV with a line for each register of the header and of block 0, and rows for docs/plc.md.
std::string map_as_csv();
std::string map_as_markdown();

}  // namespace slipd::modbus
