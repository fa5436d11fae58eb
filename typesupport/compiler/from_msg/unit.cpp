#include "from_msg/unit.h"

namespace sft::msg {

std::string_view unit_in(std::string_view comment) {
  std::string_view unit;
  while (true) {
    const std::size_t open = comment.find('[');
    if (open == comment.npos) return unit;
    const std::size_t end = comment.find_first_of(",]", open + 1);
    if (end == comment.npos) return unit;
    const bool is_unit = comment[end] == ']' && end > open + 1;
    if (is_unit && !unit.empty()) return {};
    if (is_unit) unit = comment.substr(open + 1, end - open - 1);
    comment.remove_prefix(end + 1);
  }
}

}  // namespace sft::msg
