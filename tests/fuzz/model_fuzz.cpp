// Any bytes as a trained model: it is refused with a message, or gives finite margins. The first byte selects
// whether the rest is the whole file or the body of one with a matching checksum.
#include <cmath>

#include "paper/method/knn.hpp"
#include "paper/model/model_file.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/sealed.hpp"

namespace {

using namespace slipd;
using fuzz::demand;

constexpr std::size_t kMostTaxels = 4096, kMostColumns = 4096;  // larger ones are slow, not different

void use(Model&& decoded) {
  const auto model = std::make_shared<const Model>(std::move(decoded));
  const ModelSetup& setup = model->setup();
  if (setup.layout.size() > kMostTaxels || setup.size.columns() > kMostColumns) return;
  demand(decode_model(encode_model(model->data())).setup() == setup);
  Neighbours::Query query(model->neighbours(), searched(setup));
  const std::vector<float> point(model->rank(), 0.5F);
  const KnnResult answer = answer_of(query, point, model->data().gamma, model->data().friction);
  if (answer.known) demand(answer.gamma >= 0 && answer.gamma <= 1 && answer.friction >= 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::vector<std::uint8_t> bytes(data + 1, data + size);
  if ((data[0] & 1U) != 0) bytes = fuzz::sealed("slipd-model", kModelVersion, std::move(bytes));
  try {
    use(decode_model(bytes));
  } catch (const ModelError& error) {
    demand(*error.what() != '\0');
  }
  return 0;
}
