// expect: wide strings are not sent: make the field a 'string' in the .msg file
#include "tests/compile_fail/cloud.h"

struct WideHeader {
  builtin_interfaces::msg::Time stamp;
  std::u16string frame_id;
};
auto misuse(sft::Publisher<std_msgs::msg::Header>& to, const WideHeader& header) {
  return to.publish(header);
}
