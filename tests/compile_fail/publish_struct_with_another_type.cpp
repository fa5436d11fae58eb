// expect: a member of the struct has another type than in the message: generate both from the same .msg file
#include "tests/compile_fail/cloud.h"

struct NumberedHeader {
  builtin_interfaces::msg::Time stamp;
  int frame_id;
};
auto misuse(sft::Publisher<std_msgs::msg::Header>& to, const NumberedHeader& header) {
  return to.publish(header);
}
