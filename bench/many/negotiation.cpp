// Runs groups of bench/negotiation with the bounds of this benchmark.
#include "bench/negotiation/negotiation.h"

#include <algorithm>

#include "bench/many/many.h"

namespace sft::bench {

namespace {

Scale scale_of(const ManyScale& scale) {
  return {.messages = scale.quick ? 100u : 400u, .rounds = scale.rounds};
}

Figure found(const std::vector<Figure>& figures, const std::string& name) {
  return *std::ranges::find(figures, name, &Figure::name);
}

}  // namespace

std::vector<Figure> response(const ManyScale& scale) {
  const std::vector<Figure> figures = str_response(scale_of(scale));
  Figure response = found(figures, "str_response");
  response.bound = 1.3;
  response.bound_is_of_value = false;
  return {response, found(figures, "str_response_over_helpers")};
}

std::vector<Figure> publish_to_64(const ManyScale& scale) {
  const std::vector<Figure> figures = publish_64_masks(scale_of(scale));
  Figure returns = found(figures, "publish_64_one_mask");
  returns.name = "publish_returns";
  returns.bound = 1.5;
  Figure asynchronous = found(figures, "publish_64_asynchronous");
  asynchronous.name = "publish_returns_asynchronous";
  Figure others_wait = found(figures, "publish_64_others_wait");
  others_wait.name = "publish_returns_others_wait";
  Figure allocations = found(figures, "publish_64_masks_allocations");
  allocations.name = "masks_64_allocations";
  return {returns, asynchronous, others_wait, allocations};
}

}  // namespace sft::bench
