// expect: ignoring.*sft::Node.*nodiscard
// expect: ignoring.*sft::Publisher<.*nodiscard
// expect: ignoring.*sft::Subscriber<.*nodiscard
// expect: ignoring.*sft::Service<.*nodiscard
// expect: ignoring.*sft::Client<.*nodiscard
// expect: ignoring.*set_max_rate_hz.*nodiscard
// expect: ignoring.*publish_cdr.*nodiscard
#include "tests/compile_fail/cloud.h"

#include <std_srvs/srv/SetBool.hpp>

#pragma GCC diagnostic error "-Wunused-result"

using std_srvs::srv::SetBool;
template <class T>
T opened();

void misuse(sft::Subscriber<PointCloud2>& subscriber, sft::Publisher<PointCloud2>& publisher) {
  opened<sft::Node>();
  opened<sft::Publisher<PointCloud2>>();
  opened<sft::Subscriber<PointCloud2>>();
  opened<sft::Service<SetBool>>();
  opened<sft::Client<SetBool>>();
  subscriber.set_max_rate_hz(-1);
  publisher.publish_cdr({});
}
