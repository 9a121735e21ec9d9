// Which methods the socket has, and with which parameters: the table that slipd serves by, that
// `rpc.discover` answers with, and that docs/socket.md and the clients are compared with. Called from any
// thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>
#include <vector>

namespace slipd::rpc {

// A parameter of a method.
struct Parameter {
  // Its key.
  std::string_view name;
  // Whether a request must have it.
  bool required = false;
  // JSON Schema of its value, as text.
  std::string_view schema;
  // For people: a sentence without its end.
  std::string_view description;
};

// One method.
struct MethodFacts {
  // Its name.
  std::string_view name;
  // Its parameters; a request with others is refused.
  std::vector<Parameter> parameters;
  // JSON Schema of its result, as text.
  std::string_view result;
  // For people: a sentence without its end.
  std::string_view summary;
  // Whether its answer carries a descriptor, so that it must have one, and one of its own: no notification,
  // no batch.
  bool alone = false;
};

// All methods, in the order of docs/socket.md.
std::span<const MethodFacts> methods();

// The facts of a method that exists.
const MethodFacts& facts_of(std::string_view method);

// The OpenRPC document (version 1.2.6) of these methods.
nlohmann::ordered_json open_rpc_document();

}  // namespace slipd::rpc
