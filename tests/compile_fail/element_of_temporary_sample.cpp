// expect: (use of deleted function .*operator->|selected deleted operator .->)
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Subscriber<PointCloud2, F::fields>& subscriber) { return subscriber.take()->fields()[1]; }
