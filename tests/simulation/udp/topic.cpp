#include "tests/simulation/udp/topic.h"

namespace sft::simulation {

const std::vector<FieldMask>& masks() {
  static const std::vector<FieldMask> all = {udp::test::fields<Image>("*"), udp::test::fields<Image>("data"),
                                             udp::test::fields<Image>("stamp, width")};
  return all;
}

}  // namespace sft::simulation
