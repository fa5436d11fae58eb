// expect: the struct has other members than the message
#include "tests/compile_fail/cloud.h"

struct HeaderWithSequence {
  std::uint64_t sequence;
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;
};
auto misuse(sft::Publisher<std_msgs::msg::Header>& to, const HeaderWithSequence& header) {
  return to.publish(header);
}
