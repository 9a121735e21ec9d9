// Prints the results next to the paper's figures.
#pragma once

#include <iosfwd>

#include "lab/paper/protocol.hpp"

namespace lab {

void print_table(std::ostream& out, const std::vector<Row>& rows);

}  // namespace lab
