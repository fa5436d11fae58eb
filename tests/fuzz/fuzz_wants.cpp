// What requests say beside their masks, as arbitrary bytes. What is accepted is written as bytes that say the
// same, and leads to a selection or to an error.
#include "core/control/wants.h"

#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "sft/detail/conditions.h"
#include "sft/type_support.h"

namespace sft::core {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports it as a crash
}

void check(const std::vector<std::byte>& wants) {
  Request request;
  if (!take_wants(wants, request)) return;
  Request again;
  require(take_wants(wants_of(request), again), "what is accepted is written so that it is accepted");
  require(again.min_period_us == request.min_period_us && again.parts == request.parts, "it says the same");
  const TypeSupport& type = type_support<sensor_msgs::msg::PointCloud2>();
  const Result<Selection> selection = Selection::from_bytes(request.parts, type.leaves());
  if (!selection) return;
  if (!detail::Conditions::check(type.type(), selection->gate().conditions)) return;
  const detail::Conditions conditions(type.type(), selection->gate().conditions);
  require(type.closed(*selection).mask().contains(selection->mask()), "no field gets lost");
}

}  // namespace
}  // namespace sft::core

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* const bytes = reinterpret_cast<const std::byte*>(data);
  sft::core::check({bytes, bytes + size});
  return 0;
}
