// The method `attach`: passes the board in shared memory to a client. Called from one thread: io.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "daemon/rpc/clients/client.hpp"
#include "daemon/rpc/protocol/rpc.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Once a connection and configuration, so that descriptors under way are limited by the number of clients.
// Throws rpc::Error.
void attach_to_board(ServiceContext& context, Client& client, const nlohmann::json& params,
                     const rpc::Reply& reply);

}  // namespace slipd
