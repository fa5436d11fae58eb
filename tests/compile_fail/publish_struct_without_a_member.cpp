// expect: frame_id.*HeaderWithoutFrame
#include "tests/compile_fail/cloud.h"

struct HeaderWithoutFrame {
  builtin_interfaces::msg::Time stamp;
  std::string frame;
};
auto misuse(sft::Publisher<std_msgs::msg::Header>& to, const HeaderWithoutFrame& header) {
  return to.publish(header);
}
