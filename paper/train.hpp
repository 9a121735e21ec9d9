// From a scene to its model. Takes seconds and several threads' time: for tools and the daemon's child, never
// for the process that estimates.
#pragma once

#include <vector>

#include "paper/dataset/column_source.hpp"
#include "paper/model/model.hpp"

namespace slipd {

// Equal setups give equal models, whatever the number of threads (1 … 4). Throws ModelError or
// contact::ContactError for a scene of which no model can be made (a flat skin, contacts that touch no taxel,
// a single taxel).
ModelData train(const ModelSetup& setup, unsigned threads = 2, const Progress& progress = {});

// The same model at several ranks, for hardly more time than one; setup.rank counts for nothing. `ranks` is
// not empty.
std::vector<ModelData> train_ranks(ModelSetup setup, const std::vector<int>& ranks, unsigned threads = 2,
                                   const Progress& progress = {});

}  // namespace slipd
