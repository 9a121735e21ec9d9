// The results beside the paper's own figures, for people.
#pragma once

#include <iosfwd>

#include "tools/sliplab/paper/protocol.hpp"

namespace sliplab {

void print_table(std::ostream& out, const std::vector<Row>& rows);

}  // namespace sliplab
