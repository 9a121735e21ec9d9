#include "daemon/rpc/methods/attach_request.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/rpc/clients/descriptors.hpp"
#include "daemon/rpc/protocol/request_params.hpp"

namespace slipd {
namespace {

// The slots of the shared memory that a client waits for: those of the names in "wait", else all.
std::vector<std::size_t> slots_named(const nlohmann::json& params, const Board& board) {
  const std::size_t sensors = board.sensors.size();
  const auto wait = params.find("wait");
  std::vector<std::size_t> slots;
  if (wait != params.end() && !wait->is_array())
    throw rpc::Error(rpc::kInvalidParams, "\"wait\" must be a list of names of sensors and grasps");
  const auto wanted = [&](const std::string& name) {
    return wait == params.end() || std::find(wait->begin(), wait->end(), name) != wait->end();
  };
  for (std::size_t i = 0; i < sensors; ++i) {
    if (wanted(board.sensors[i]->name)) slots.push_back(i);
  }
  for (std::size_t i = 0; i < board.grasps.size(); ++i) {
    if (wanted(board.grasps[i]->name)) slots.push_back(sensors + i);
  }
  if (wait == params.end()) return slots;
  for (const nlohmann::json& name : *wait) {
    const auto is_it = [&](const auto& each) { return name == each->name; };
    if (std::none_of(board.grasps.begin(), board.grasps.end(), is_it)) sensor_index(name, board);  // throws
  }
  return slots;
}

}  // namespace

void attach_to_board(ServiceContext& context, Client& client, const nlohmann::json& params,
                     const rpc::Reply& reply) {
  Board& board = context.board;
  std::vector<std::size_t> slots = slots_named(params, board);
  std::vector<std::string> sensors, grasps;
  for (const auto& sensor : board.sensors) sensors.push_back(sensor->name);
  for (const auto& grasp : board.grasps) grasps.push_back(grasp->name);
  try {
    board.shared.open(sensors, grasps);
    if (client.attachment != nullptr && client.attached_generation == board.shared.generation()) {
      throw rpc::Error(
          rpc::kNotPossible,
          "this connection has attached already; use the descriptor that it got, or connect anew");
    }
    UniqueFd descriptor = out_of_the_way(board.shared.descriptor());
    client.attachment = board.shared.wait_for(slots);
    client.attached_generation = board.shared.generation();
    client.pass_with_response(std::move(descriptor));
  } catch (const std::system_error& error) {
    throw rpc::Error(rpc::kNotPossible, error.what());
  }
  context.ring_estimate();
  reply.result({{"bytes", board.shared.bytes()},
                {"generation", board.shared.generation()},
                {"sensors", sensors},
                {"grasps", grasps}});
}

}  // namespace slipd
