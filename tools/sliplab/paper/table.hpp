// Prints the results next to the paper's figures.
#pragma once

#include <iosfwd>

#include "tools/sliplab/paper/protocol.hpp"

namespace sliplab {

void print_table(std::ostream& out, const std::vector<Row>& rows);

}  // namespace sliplab
