// What slipd-grip is doing, what makes it do something else, and the table of both: docs/grip.md's diagram is
// made from it. Plain values; any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace slipd::grip {

enum class State : std::uint8_t {
  idle,        // since the start: it has ordered nothing, and what the gripper does is not known
  open,        // it was told to open
  closing,     // until there is a contact
  missed,      // closed, and there is no object
  holding,     // with a margin that suffices
  tightening,  // the margin falls short, or will before the gripper has followed
  reacting,    // the object slips
  firm,        // there is no margin: with the firm force
  cut_off      // the gripper does not answer
};

enum class Event : std::uint8_t {
  close_order,
  open_order,
  contact,         // the sensors feel something
  no_object,       // there was no contact in time
  margin_good,     // a valid margin that suffices
  margin_low,      // a valid margin below the target, now or soon
  slip,            // an alert of slip, or a slide was seen
  margin_unknown,  // any state of the estimate but ok; also an estimate too old, or no slipd
  gripper_gone,
  gripper_back
};

struct Transition {
  State from;
  Event event;
  State to;
};

// All that lead to another state; with any other event the state stays.
std::span<const Transition> transitions() noexcept;

State next_state(State state, Event event) noexcept;

std::string_view to_string(State state) noexcept;  // "cut off", …
std::string_view to_string(Event event) noexcept;  // "margin good", …

// Whether something may be in the grip: states in which the force does not fall without a margin.
bool is_gripping(State state) noexcept;

// The table as a Mermaid state diagram.
std::string diagram();

}  // namespace slipd::grip
