#include "grip/transitions.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace slipd::grip {
namespace {

using enum State;
using enum Event;

constexpr Transition kTransitions[] = {
    {idle, contact, firm},
    {idle, close_order, closing},
    {idle, open_order, open},
    {open, close_order, closing},
    {closing, contact, firm},
    {closing, margin_good, holding},
    {closing, margin_low, tightening},
    {closing, slip, reacting},
    {closing, margin_unknown, firm},
    {closing, no_object, missed},
    {closing, open_order, open},
    {closing, gripper_gone, cut_off},
    {missed, contact, firm},
    {missed, close_order, closing},
    {missed, open_order, open},
    {missed, gripper_gone, cut_off},
    {holding, margin_low, tightening},
    {holding, slip, reacting},
    {holding, margin_unknown, firm},
    {holding, open_order, open},
    {holding, gripper_gone, cut_off},
    {tightening, margin_good, holding},
    {tightening, slip, reacting},
    {tightening, margin_unknown, firm},
    {tightening, open_order, open},
    {tightening, gripper_gone, cut_off},
    {reacting, margin_good, holding},
    {reacting, margin_low, tightening},
    {reacting, margin_unknown, firm},
    {reacting, open_order, open},
    {reacting, gripper_gone, cut_off},
    {firm, margin_good, holding},
    {firm, margin_low, tightening},
    {firm, slip, reacting},
    {firm, open_order, open},
    {firm, gripper_gone, cut_off},
    {cut_off, gripper_back, firm},
    {cut_off, open_order, open},
};

constexpr std::string_view kStates[] = {"idle",       "open",     "closing", "missed", "holding",
                                        "tightening", "reacting", "firm",    "cut off"};
constexpr std::string_view kEvents[] = {"close",        "open",        "contact", "no object",
                                        "margin good",  "margin low",  "slip",    "margin unknown",
                                        "gripper gone", "gripper back"};

// As Mermaid wants names: without spaces.
std::string identifier(State state) {
  std::string name(to_string(state));
  std::ranges::replace(name, ' ', '_');
  return name;
}

}  // namespace

std::span<const Transition> transitions() noexcept {
  return kTransitions;
}

State next_state(State state, Event event) noexcept {
  const auto* const found = std::ranges::find_if(
      kTransitions, [&](const Transition& one) { return one.from == state && one.event == event; });
  return found == std::end(kTransitions) ? state : found->to;
}

std::string_view to_string(State state) noexcept {
  return kStates[static_cast<std::size_t>(state)];
}

std::string_view to_string(Event event) noexcept {
  return kEvents[static_cast<std::size_t>(event)];
}

bool is_gripping(State state) noexcept {
  return state == holding || state == tightening || state == reacting || state == firm || state == cut_off;
}

std::string diagram() {
  std::string text = "stateDiagram-v2\n  [*] --> idle\n";
  std::vector<std::pair<std::pair<State, State>, std::string>> arrows;
  for (const Transition& one : kTransitions) {
    const std::pair ends{one.from, one.to};
    const auto found = std::ranges::find(arrows, ends, [](const auto& arrow) { return arrow.first; });
    if (found == arrows.end())
      arrows.emplace_back(ends, to_string(one.event));
    else
      found->second += std::string(", ") + std::string(to_string(one.event));
  }
  for (const auto& [ends, events] : arrows)
    text += "  " + identifier(ends.first) + " --> " + identifier(ends.second) + ": " + events + "\n";
  return text;
}

}  // namespace slipd::grip
